#include "LiveSurfaceFixture.h"

#include <isofront/surface/SharedCells.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

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

TEST(SharedCells, countMeshesOnceForAsLongAsAnybodyHasThem)
{
    const extractor::CellExtractor extractor(
        std::make_shared<Hills>(), {}, smallOptions().extraction);
    auto cells = std::make_unique<SharedCells>(std::size_t{1} << 20U);
    auto one = cells->extract(extractor, kCell);
    auto other = cells->extract(extractor, kCell);
    const std::size_t bytes = one->bytes();
    EXPECT_EQ(cells->stats().liveBytes, bytes);
    cells->setCapacity(0);
    EXPECT_EQ(cells->stats().liveBytes, bytes);
    one.reset();
    EXPECT_EQ(cells->stats().liveBytes, bytes);
    other.reset();
    EXPECT_EQ(cells->stats().liveBytes, 0U);
    one = cells->extract(extractor, kCell);
    cells.reset();
    EXPECT_GT(one->triangleCount(), 0U); // outlives where it is from
}

// Surfaces that have what they share taken away all the time, and want different things at once.
TEST(SharedCells, changeNothingHoweverLittleIsKept)
{
    SurfaceOptions options = smallOptions();
    options.pixelError = 8;
    options.maxTriangles = 2500; // less than these views want
    const hierarchy::View near = viewFrom({0.4, 0.3, 0.62});
    const hierarchy::View far = viewFrom({0.7, 0.6, 0.75});
    const auto field = std::make_shared<Hills>();
    const auto expected = [&](const hierarchy::View& view, double isovalue) {
        Surface alone(field, {}, options, jobsOf(core::JobsBackend::automatic));
        alone.setIsovalue(isovalue);
        Host host;
        settleInto(alone, host, view);
        return host;
    };
    const Host here = expected(near, 0.0);
    const Host there = expected(far, 0.02);
    ASSERT_GT(here.triangles(), 500U);
    for (const std::size_t kept : {std::size_t{0}, std::size_t{20'000}, std::size_t{1} << 26U}) {
        SurfaceOptions sharing = options;
        sharing.shared = std::make_shared<SharedCells>(kept);
        const auto jobs = jobsOf(core::JobsBackend::automatic);
        Surface one(field, {}, sharing, jobs);
        Surface other(field, {}, sharing, jobs);
        Host hosts[2];
        const auto step = [&](const hierarchy::View& ones, const hierarchy::View& others) {
            for (int i = 0; i < 3; ++i) {
                hosts[0].apply(one.update(ones, {.milliseconds = 1}));
                hosts[1].apply(other.update(others, {.milliseconds = 1}));
            }
        };
        for (int i = 0; i < 4; ++i) { // jumps, and isovalues that are given up again
            one.setIsovalue(0.01 * i);
            other.setIsovalue(0.01 * (3 - i));
            step(i % 2 == 0 ? near : far, i % 2 == 0 ? far : near);
        }
        one.setIsovalue(0.0);
        other.setIsovalue(0.02);
        settleInto(one, hosts[0], near);
        settleInto(other, hosts[1], far);
        for (const auto& [host, alone] :
             {std::pair(&hosts[0], &here), std::pair(&hosts[1], &there)}) {
            EXPECT_EQ(host->cracks(), 0U);
            EXPECT_LE(host->triangles(), options.maxTriangles);
            ASSERT_EQ(host->cells().size(), alone->cells().size()) << kept;
            for (const auto& [id, mesh] : host->cells()) {
                ASSERT_EQ(mesh->vertices, alone->cells().at(id)->vertices);
                ASSERT_EQ(mesh->indices, alone->cells().at(id)->indices);
            }
        }
        EXPECT_LE(sharing.shared->stats().bytes, kept);
    }
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
