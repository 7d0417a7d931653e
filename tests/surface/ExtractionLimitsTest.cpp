#include "CeilingSearch.h"
#include "SurfaceGrowth.h"

#include <isofront/fields/Shapes.h>
#include <isofront/surface/MeshExtraction.h>

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace isofront::surface {
namespace {

/// A ball that counts what it is asked: the measure of work that doesn't depend on the machine.
class CountedBall final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        samples += batch.size();
        _ball->sample(batch, values);
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        ++boxes;
        return _ball->bounds(box, radius);
    }
    [[nodiscard]] double differenceStep(double radius) const override
    {
        return _ball->differenceStep(radius);
    }
    mutable std::atomic<std::uint64_t> samples{0};
    mutable std::atomic<std::uint64_t> boxes{0};

private:
    std::shared_ptr<const fields::Field> _ball = fields::sphere({0.503, 0.491, 0.507}, 0.37);
};

std::shared_ptr<const extractor::CellExtractor> ballExtractor(
    bool estimateError = false,
    std::shared_ptr<const fields::Field> ball = std::make_shared<CountedBall>())
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = 4;
    settings.filterStrength = 0;
    settings.estimateError = estimateError;
    return std::make_shared<const extractor::CellExtractor>(
        std::move(ball), hierarchy::Domain{}, settings);
}

TEST(SurfaceGrowth, foretellsASurfaceAndKnowsWhenItCanNot)
{
    SurfaceGrowth surface;
    SurfaceGrowth volume;
    SurfaceGrowth point;
    for (int level = 0; level <= 12; ++level) {
        for (int i = 0; i < static_cast<int>(6 * std::exp2(level * 2 / 3.0)); ++i)
            surface.add(level);
        for (int i = 0; i < static_cast<int>(6 * std::exp2(level)); ++i)
            volume.add(level);
        for (int i = 0; i < 30; ++i)
            point.add(level);
    }
    for (const int level : {13, 15, 30, 60}) {
        const auto expected = surface.expectedAt(level, 12);
        ASSERT_TRUE(expected.has_value());
        EXPECT_NEAR(std::log2(*expected / (6 * std::exp2(level * 2 / 3.0))), 0, 0.2) << level;
        // what grows as a volume may turn out to be a surface in the end
        const auto least = volume.expectedAt(level, 12);
        ASSERT_TRUE(least.has_value());
        EXPECT_NEAR(*least, 6 * 4096 * std::exp2((level - 12) * 2 / 3.0), 0.01 * *least);
        EXPECT_FALSE(point.expectedAt(level, 12).has_value());
        EXPECT_FALSE(surface.expectedAt(level, 5).has_value());
    }
}

TEST(CeilingSearch, findsTheLeastCoarseStepThatFitsInFewTrials)
{
    // the true number falls faster or slower than is believed, in places not at all
    for (const double believed : {0.63, 0.84})
        for (const double real : {0.5, 0.7, 0.9})
            for (const double most : {1.0, 50.0, 12345.0, 1e6, 1e9}) {
                const auto trianglesAt = [&](int step) {
                    return std::floor(4e6 * std::pow(real, step - step % 2));
                };
                constexpr int kLast = 200;
                CeilingSearch search(most, believed, kLast);
                int trials = 0;
                int best = -1;
                while (const auto step = search.next()) {
                    ASSERT_LT(++trials, 60);
                    const bool fits = trianglesAt(*step) <= most;
                    // what does not fit is not counted to its end
                    search.tell(trianglesAt(*step) * (fits ? 1 : 0.7), fits);
                    if (fits)
                        best = *step;
                }
                int least = 0;
                while (trianglesAt(least) > most)
                    ++least;
                EXPECT_EQ(best, least) << believed << ' ' << real << ' ' << most;
            }
    CeilingSearch hopeless(1, 0.5, 7);
    int trials = 0;
    while (hopeless.next()) {
        hopeless.tell(1000, false);
        ASSERT_LT(++trials, 9);
    }
}

TEST(ExtractionLimits, keepsTheTrianglesBelowTheirCeilingAndNoCoarserThanThat)
{
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    for (const Detail::Kind kind : {Detail::Kind::level, Detail::Kind::error, Detail::Kind::view}) {
        const auto extractor = ballExtractor(kind == Detail::Kind::error);
        MeshExtractionOptions options;
        options.detail.kind = kind;
        options.detail.level = kind == Detail::Kind::level ? 12 : 30;
        options.detail.maxError = 5e-4;
        options.detail.view.eye = {3, 0.2, 0.1};
        options.detail.view.height = 400;
        options.detail.pixelError = 1;
        const auto whole = extractMesh(extractor, *jobs, options);
        ASSERT_TRUE(whole.has_value());
        const std::size_t all = whole->mesh.indices.size() / 3;
        EXPECT_EQ(whole->coarser, 1.0);

        options.maxTriangles = all; // it just fits
        const auto same = extractMesh(extractor, *jobs, options);
        ASSERT_TRUE(same.has_value());
        EXPECT_EQ(same->coarser, 1.0);
        EXPECT_EQ(same->mesh.indices, whole->mesh.indices);
        EXPECT_TRUE(same->mesh.positions == whole->mesh.positions);

        options.maxTriangles = all / 5;
        const auto fewer = extractMesh(extractor, *jobs, options);
        ASSERT_TRUE(fewer.has_value());
        EXPECT_LE(fewer->mesh.indices.size() / 3, options.maxTriangles);
        EXPECT_GT(fewer->coarser, 1.0);

        // what it says that it was made by makes it again, and a step finer has too many; errors
        // alone don't tell how coarse the refinement began
        if (kind == Detail::Kind::error)
            continue;
        MeshExtractionOptions plain;
        plain.detail = fewer->detail;
        const auto again = extractMesh(extractor, *jobs, plain);
        ASSERT_TRUE(again.has_value());
        EXPECT_EQ(again->mesh.indices, fewer->mesh.indices);
        if (kind == Detail::Kind::level) {
            EXPECT_EQ(fewer->coarser, std::exp2((12 - fewer->detail.level) / 3.0));
            ++plain.detail.level;
        }
        plain.detail.pixelError *= std::exp2(-1.0 / 8);
        const auto finer = extractMesh(extractor, *jobs, plain);
        ASSERT_TRUE(finer.has_value());
        EXPECT_GT(finer->mesh.indices.size() / 3, options.maxTriangles);
    }
}

TEST(ExtractionLimits, saysSoWhereNoMeshHasSoFewTriangles)
{
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    MeshExtractionOptions options;
    options.detail.level = 9;
    options.maxTriangles = 1;
    const auto none = extractMesh(ballExtractor(), *jobs, options);
    ASSERT_FALSE(none.has_value());
    EXPECT_EQ(none.error().code, core::ErrorCode::resourceLimit);
    EXPECT_NE(none.error().message.find("--max-triangles"), std::string::npos);
}

TEST(ExtractionLimits, refusesAbsurdLevelsAtOnceAndFitsThemUnderACeiling)
{
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    MeshExtractionOptions options;
    for (const int level : {40, 60, 92}) {
        options.detail.level = level;
        const auto ball = std::make_shared<CountedBall>();
        const auto refused = extractMesh(ballExtractor(false, ball), *jobs, options);
        EXPECT_LT(ball->boxes, 10'000U);
        EXPECT_EQ(ball->samples, 0U);
        ASSERT_FALSE(refused.has_value());
        EXPECT_EQ(refused.error().code, core::ErrorCode::resourceLimit);
        // the estimate, the limit and what to do
        for (const char* word : {"would need about", "8192 MiB", "choose level", "--memory-limit"})
            EXPECT_NE(refused.error().message.find(word), std::string::npos)
                << refused.error().message;
    }
    options.maxTriangles = 20'000;
    const auto fitted = extractMesh(ballExtractor(), *jobs, options);
    ASSERT_TRUE(fitted.has_value());
    EXPECT_LE(fitted->mesh.indices.size() / 3, options.maxTriangles);
    EXPECT_GT(fitted->mesh.indices.size() / 3, options.maxTriangles / 4);
}

TEST(ExtractionLimits, tellsHowFarItIsAndStopsSoonWhileItFindsCells)
{
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    std::stop_source source;
    std::vector<double> shares;
    MeshExtractionOptions options;
    options.detail.level = 26; // millions of cells
    options.memoryLimit = std::size_t{1} << 40U;
    options.stop = source.get_token();
    const auto ball = std::make_shared<CountedBall>();
    std::uint64_t asked = 0;
    options.progress = [&](const char* what, double share) {
        EXPECT_STREQ(what, "finding cells");
        shares.push_back(share);
        if (share > 0.01 && !source.stop_requested()) {
            asked = ball->boxes;
            source.request_stop();
        }
    };
    const auto stopped = extractMesh(ballExtractor(false, ball), *jobs, options);
    ASSERT_FALSE(stopped.has_value());
    EXPECT_EQ(stopped.error().code, core::ErrorCode::interrupted);
    EXPECT_LT(ball->boxes - asked, 10'000U) << "of millions";
    ASSERT_GT(shares.size(), 10U);
    EXPECT_GT(shares.front(), 0.0);
    EXPECT_LT(shares.front(), 1e-4);
    for (std::size_t i = 1; i < shares.size(); ++i)
        ASSERT_LE(shares[i - 1], shares[i]);
}

} // namespace
} // namespace isofront::surface
