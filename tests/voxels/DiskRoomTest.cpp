#include "ChunkCodec.h"
#include "Models.h"

#include <isofront/voxels/DiskRoom.h>
#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

namespace isofront::voxels {
namespace {

constexpr std::uint64_t kGib = std::uint64_t{1} << 30U;

DiskFolder folderWith(const std::string& path, std::uint64_t disk, std::uint64_t freeBytes)
{
    return {.path = path, .disk = disk, .freeBytes = freeBytes};
}

/// What the chunks of all levels take in stores.
class MeasuringSink final : public ChunkSink {
public:
    std::optional<core::Error> put(Chunk chunk) override
    {
        bytes += encoded(chunk).size();
        return std::nullopt;
    }
    std::uint64_t bytes = 0;
};

TEST(DiskRoom, isToldNearlyByATrial)
{
    TriangleModel model = tests::hillySphere(80, 10, 1.5);
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    for (const bool isColoured : {false, true}) {
        if (isColoured)
            for (std::size_t i = 0; i < model.positions.size(); ++i)
                model.colours.push_back(0xff000000U + static_cast<std::uint32_t>(i));
        constexpr std::uint32_t kTrial = 96;
        TrialSink trial;
        const auto coarse = voxelize(model, {.resolution = kTrial}, trial, *jobs);
        ASSERT_TRUE(coarse);
        for (const std::uint32_t resolution : {192U, 384U}) {
            MeasuringSink all;
            const auto fine = voxelize(model, {.resolution = resolution}, all, *jobs);
            ASSERT_TRUE(fine);
            const DiskNeed need = neededAt(resolution, kTrial, trial.bytes(), coarse->scratchBytes);
            const auto stored = static_cast<double>(need.model);
            EXPECT_GT(stored, 0.9 * static_cast<double>(all.bytes)) << resolution;
            EXPECT_LT(stored, 1.4 * static_cast<double>(all.bytes)) << resolution;
            EXPECT_NEAR(
                static_cast<double>(need.scratch) / static_cast<double>(fine->scratchBytes),
                1,
                0.25)
                << resolution;
        }
    }
}

TEST(DiskRoom, isRefusedWithAResolutionThatFits)
{
    constexpr std::uint32_t kResolution = 16384;
    const DiskNeed need{.model = 20 * kGib, .scratch = 60 * kGib};
    const auto check = [&](std::uint64_t freeModel, std::uint64_t freeScratch, bool isOne) {
        return checkDiskRoom(
            need,
            kResolution,
            folderWith("models", 1, freeModel * kGib),
            folderWith("waiting", isOne ? 1 : 2, freeScratch * kGib));
    };
    EXPECT_TRUE(check(80, 80, true));
    EXPECT_TRUE(check(60, 60, true)) << "estimates may be a quarter too high";
    EXPECT_TRUE(check(20, 60, false));
    EXPECT_FALSE(check(10, 60, false));
    EXPECT_FALSE(check(20, 40, false));
    const auto refused = check(20, 20, true);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, core::ErrorCode::resourceLimit);
    for (const char* part : {"models", "20 GiB are free", "about 80 GiB", "16384", "8100"})
        EXPECT_NE(refused.error().message.find(part), std::string::npos)
            << part << ": " << refused.error().message;
    EXPECT_NE(check(20, 15, false).error().message.find("waiting: 15 GiB"), std::string::npos);
    // the resolution that is named is itself not refused
    for (std::uint64_t freeBytes = kGib / 16; freeBytes < 60 * kGib; freeBytes *= 3) {
        const DiskFolder folder = folderWith("models", 1, freeBytes);
        const auto failed = checkDiskRoom(need, kResolution, folder, folder);
        ASSERT_FALSE(failed);
        const std::string& message = failed.error().message;
        const std::string words = "--resolution ";
        const auto at = message.find(words);
        ASSERT_NE(at, std::string::npos) << message;
        const std::uint32_t fits =
            static_cast<std::uint32_t>(std::stoul(message.substr(at + words.size())));
        const double share = static_cast<double>(fits) / kResolution;
        const auto scaled = [&](std::uint64_t bytes) {
            return static_cast<std::uint64_t>(static_cast<double>(bytes) * share * share);
        };
        EXPECT_TRUE(
            checkDiskRoom({scaled(need.model), scaled(need.scratch)}, fits, folder, folder));
        EXPECT_GT(fits, 0.5 * kResolution * std::sqrt(double(freeBytes) / double(80 * kGib)));
    }
    const DiskFolder full = folderWith("models", 1, 0);
    const auto nothing = checkDiskRoom(need, kResolution, full, full);
    ASSERT_FALSE(nothing);
    EXPECT_EQ(nothing.error().message.find("--resolution"), std::string::npos);
}

TEST(DiskRoom, isAskedForByATrialOnlyWhereItIsInDoubt)
{
    const DiskFolder ample = folderWith("a", 1, 1000 * kGib);
    const DiskFolder scarce = folderWith("b", 2, kGib);
    EXPECT_FALSE(trialResolution(16384, ample, ample));
    EXPECT_EQ(trialResolution(16384, scarce, ample), 512U);
    EXPECT_EQ(trialResolution(16384, ample, scarce), 512U);
    EXPECT_EQ(trialResolution(1600, scarce, scarce), 400U);
    EXPECT_FALSE(trialResolution(800, scarce, scarce)) << "whatever it is, it fits";
    const DiskFolder full = folderWith("c", 3, 0);
    EXPECT_EQ(trialResolution(256, full, full), 64U);
    EXPECT_FALSE(trialResolution(255, full, full));
    EXPECT_EQ(trialResolution(kMaxResolution, full, full), 512U);
}

TEST(DiskRoom, isThatOfTheSystem)
{
    const auto here = diskFolderOf(".");
    ASSERT_TRUE(here) << here.error().message;
    const auto same = diskFolderOf(std::filesystem::current_path());
    ASSERT_TRUE(same);
    EXPECT_EQ(here->disk, same->disk);
    EXPECT_GT(here->freeBytes, 0U);
    const auto none = diskFolderOf("no/where");
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(none.error().message.find("no/where"), std::string::npos);
}

} // namespace
} // namespace isofront::voxels
