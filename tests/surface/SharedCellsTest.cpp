#include "LiveSurfaceFixture.h"

#include <isofront/surface/SharedCells.h>

#include <atomic>
#include <mutex>
#include <set>
#include <thread>

namespace isofront::surface {
namespace {

/// The hills, counting who asks for samples at once, and waiting where told.
class CountedHills final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        ++begun;
        while (!isOpen)
            std::this_thread::yield();
        Hills().sample(batch, values);
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return Hills().bounds(box, radius);
    }
    [[nodiscard]] double differenceStep(double) const override { return 1e-4; }

    mutable std::atomic<int> begun{0};
    std::atomic<bool> isOpen{true};
};

const CellId kCell{hierarchy::kRootDiamond, 0};

TEST(SharedCells, extractsACellOnceForAllWhoAskAtOnce)
{
    const auto field = std::make_shared<CountedHills>();
    field->isOpen = false;
    const extractor::CellExtractor extractor(field, {}, smallOptions().extraction);
    SharedCells cells(std::size_t{1} << 20U);
    std::mutex mutex;
    std::set<const extractor::CellMesh*> meshes;
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 8; ++i)
            threads.emplace_back([&] {
                const auto mesh = cells.extract(extractor, kCell);
                const std::lock_guard lock(mutex);
                meshes.insert(mesh.get());
            });
        while (field->begun == 0)
            std::this_thread::yield();
        field->isOpen = true;
    }
    EXPECT_EQ(meshes.size(), 1U);
    EXPECT_EQ(cells.stats().extracted, 1U);
    EXPECT_EQ(cells.stats().shared, 7U);
    EXPECT_EQ(cells.stats().cells, 1U);
    const auto mesh = cells.extract(extractor, kCell);
    const auto expected = extractor.extract(hierarchy::tetrahedronOf(kCell));
    EXPECT_EQ(mesh->vertices, expected->vertices);
    EXPECT_EQ(mesh->indices, expected->indices);
}

TEST(SharedCells, letsAnotherDoWhatWasTakenBack)
{
    const auto field = std::make_shared<CountedHills>();
    field->isOpen = false;
    const extractor::CellExtractor extractor(field, {}, smallOptions().extraction);
    SharedCells cells(std::size_t{1} << 20U);
    std::atomic<bool> cancelled{false};
    std::shared_ptr<const extractor::CellMesh> first;
    std::shared_ptr<const extractor::CellMesh> second;
    {
        const std::jthread taken([&] { first = cells.extract(extractor, kCell, &cancelled); });
        while (field->begun == 0)
            std::this_thread::yield();
        const std::jthread other([&] { second = cells.extract(extractor, kCell); });
        cancelled = true;
        field->isOpen = true;
    }
    EXPECT_EQ(first, nullptr);
    ASSERT_NE(second, nullptr);
    EXPECT_GT(second->triangleCount(), 0U);
    EXPECT_EQ(cells.stats().extracted, 1U);
}

TEST(SharedCells, keepsApartWhatDiffersAndStaysBelowItsBound)
{
    const auto field = std::make_shared<CountedHills>();
    SharedCells cells(std::size_t{1} << 20U);
    extractor::ExtractionSettings settings = smallOptions().extraction;
    const auto ask = [&] {
        return cells.extract(extractor::CellExtractor(field, {}, settings), kCell);
    };
    const auto plain = ask();
    settings.isovalue = 0.02;
    const auto higher = ask();
    settings.isovalue = 0;
    settings.latticeSize = 8;
    const auto finer = ask();
    EXPECT_NE(plain->vertices, higher->vertices);
    EXPECT_LT(plain->triangleCount(), finer->triangleCount());
    settings.isovalue = -0.0;
    EXPECT_EQ(ask(), finer);
    EXPECT_EQ(cells.stats().cells, 3U);

    cells.setCapacity(cells.stats().bytes - 1); // the least recently used goes
    EXPECT_EQ(cells.stats().cells, 2U);
    EXPECT_EQ(ask(), finer);
    cells.setCapacity(0);
    EXPECT_EQ(cells.stats().bytes, 0U);
    EXPECT_EQ(ask()->vertices, finer->vertices);
    EXPECT_EQ(cells.stats().cells, 0U);
}

TEST(SharedCells, changeNothingOfWhatSurfacesShow)
{
    SurfaceOptions options = smallOptions();
    options.pixelError = 8;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    const auto field = std::make_shared<Hills>();
    const auto jobs = jobsOf(core::JobsBackend::automatic);
    Surface alone(field, {}, options, jobs);
    Host expected;
    settleInto(alone, expected, view);

    options.shared = std::make_shared<SharedCells>(std::size_t{64} << 20U);
    Surface one(field, {}, options, jobs);
    Surface other(field, {}, options, jobs);
    for (Surface* surface : {&one, &other}) {
        Host host;
        settleInto(*surface, host, view);
        ASSERT_EQ(host.cells().size(), expected.cells().size());
        for (const auto& [id, mesh] : host.cells())
            ASSERT_EQ(mesh->vertices, expected.cells().at(id)->vertices);
        surface->setIsovalue(0.02);
        settleInto(*surface, host, view);
        EXPECT_EQ(host.cracks(), 0U);
    }
    EXPECT_GT(options.shared->stats().shared, options.shared->stats().extracted / 2);
}

} // namespace
} // namespace isofront::surface
