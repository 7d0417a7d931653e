#include "LiveSurfaceFixture.h"
#include "support/Random.h"

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Diamond.h>
#include <isofront/surface/Surface.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <stop_token>
#include <thread>
#include <unordered_map>

namespace isofront::surface {
namespace {

/// A flight over the hills, with a turn back and a jump.
glm::dvec3 flightAt(int frame)
{
    const double t = frame / 60.0;
    if (frame >= 40 && frame < 50)
        return {0.15, 0.85, 0.62};
    return {0.2 + 0.6 * (t < 0.5 ? t : 1 - t), 0.3 + 0.4 * t, 0.66 + 0.05 * std::sin(9 * t)};
}

class SurfaceOnJobs : public testing::TestWithParam<core::JobsBackend> {};

TEST_P(SurfaceOnJobs, isCrackFreeAfterEveryDeltaOfAFlight)
{
    Surface surface(
        std::make_shared<Hills>(),
        {},
        smallOptions(),
        std::shared_ptr<core::Jobs>(core::makeJobs(GetParam(), 3)));
    Host host;
    std::size_t deltas = 0;
    for (int frame = 0; frame < 60; ++frame)
        for (int update = 0; update < 3; ++update) {
            const Delta delta = surface.update(viewFrom(flightAt(frame)), {.milliseconds = 3});
            if (delta.isEmpty())
                continue;
            ++deltas;
            ASSERT_EQ(delta.version, deltas);
            host.apply(delta);
            ASSERT_EQ(host.cracks(), 0U) << "frame " << frame;
            ASSERT_EQ(host.triangles(), surface.stats().triangles);
        }
    settleInto(surface, host, viewFrom(flightAt(59)));
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_GT(deltas, 5U);
    EXPECT_GT(surface.stats().cellsExtracted, 100U);
    EXPECT_GT(surface.stats().cellsSkipped, 100U);
}

TEST_P(SurfaceOnJobs, endsWithTheMeshesOfItsCellsWhateverTheOrderOfWork)
{
    const auto field = std::make_shared<Hills>();
    const SurfaceOptions options = smallOptions();
    Surface surface(field, {}, options, std::shared_ptr<core::Jobs>(core::makeJobs(GetParam(), 2)));
    Host host;
    for (int frame = 0; frame < 30; ++frame)
        host.apply(surface.update(viewFrom(flightAt(frame)), {.milliseconds = 1}));
    settleInto(surface, host, viewFrom(flightAt(29)));

    extractor::ExtractionSettings settings = options.extraction;
    const extractor::CellExtractor extractor(field, {}, settings);
    for (const auto& [id, mesh] : host.cells()) {
        const auto expected = extractor.extract(hierarchy::tetrahedronOf(id));
        ASSERT_EQ(mesh->vertices, expected->vertices);
        ASSERT_EQ(mesh->indices, expected->indices);
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, SurfaceOnJobs, kBackends, backendName);

TEST(Surface, settlesAtOnceIntoWhatUpdatesLeadTo)
{
    const auto field = std::make_shared<Hills>();
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    Surface stepwise(field, {}, smallOptions());
    Host host;
    settleInto(stepwise, host, view);

    Surface direct(field, {}, smallOptions());
    Host other;
    double last = -1;
    other.apply(direct.settle(view, [&](double share) {
        EXPECT_GE(share, last);
        last = share;
    }));
    EXPECT_EQ(last, 1.0);
    EXPECT_TRUE(direct.isSettled());
    EXPECT_TRUE(direct.update(view).isEmpty());
    ASSERT_EQ(host.cells().size(), other.cells().size());
    for (const auto& [id, mesh] : host.cells())
        ASSERT_EQ(mesh->vertices, other.cells().at(id)->vertices);

    // and on from there, by steps and by a jump
    for (int i = 0; i < 20; ++i)
        other.apply(direct.update(viewFrom({0.4 + 0.01 * i, 0.3, 0.65}), {.milliseconds = 2}));
    other.apply(direct.settle(viewFrom({0.8, 0.8, 0.6})));
    EXPECT_TRUE(direct.isSettled());
    EXPECT_EQ(other.cracks(), 0U);
    // the direct way skips what lies between
    EXPECT_LT(direct.stats().deltas, stepwise.stats().deltas + 22);
}

TEST(Surface, isAsFineAsEverWithinItsReachAndCrackFreeBeyond)
{
    const auto field = std::make_shared<Hills>();
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    Surface whole(field, {}, smallOptions());
    Host all;
    all.apply(whole.settle(view));

    constexpr double kReach = 0.2;
    SurfaceOptions options = smallOptions();
    options.detail.reach = kReach;
    Surface surface(field, {}, options);
    Host near;
    near.apply(surface.settle(view));
    EXPECT_EQ(near.cracks(), 0U);
    EXPECT_LT(4 * near.triangles(), 3 * all.triangles());
    std::size_t within = 0;
    for (const auto& [id, mesh] : all.cells()) {
        const hierarchy::Tetrahedron cell = hierarchy::tetrahedronOf(id);
        const glm::dvec3 low = hierarchy::Domain{}.fieldFromLattice(cell.low());
        const glm::dvec3 high = hierarchy::Domain{}.fieldFromLattice(cell.high());
        // a cell is part of the sphere of the diamond that was split for it
        glm::dvec3 furthest = glm::max(glm::abs(low - view.eye), glm::abs(high - view.eye));
        if (glm::length(furthest) > kReach)
            continue;
        ++within;
        ASSERT_TRUE(near.cells().contains(id));
        EXPECT_EQ(near.cells().at(id)->vertices, mesh->vertices);
    }
    EXPECT_GT(within, 10U);

    // and it may change at any time
    surface.setDetail(options.pixelError, {});
    settleInto(surface, near, view);
    EXPECT_EQ(near.cells().size(), all.cells().size());
    EXPECT_EQ(near.cracks(), 0U);
}

TEST(Surface, stopsSettlingOnRequestAndLosesNothing)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    Host host;
    std::stop_source source;
    source.request_stop();
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    EXPECT_TRUE(surface.settle(view, {}, source.get_token()).isEmpty());
    settleInto(surface, host, view);
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_GT(host.triangles(), 1000U);
}

TEST(Surface, neverWaitsForAnExtraction)
{
    // a field that doesn't answer until it is allowed to
    class Stuck final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            while (!open)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(Hills::value({batch.x[i], batch.y[i], batch.z[i]}));
        }
        [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
        {
            return {};
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
        std::atomic<bool> open{false};
    };
    const auto field = std::make_shared<Stuck>();
    SurfaceOptions options = smallOptions();
    options.maxLevel = 9;
    Surface surface(
        field,
        {},
        options,
        std::shared_ptr<core::Jobs>(core::makeJobs(core::JobsBackend::threads, 2)));
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.65});
    for (int i = 0; i < 10; ++i) // would hang here
        EXPECT_TRUE(surface.update(view).isEmpty());
    EXPECT_GT(surface.stats().pendingCells, 0U);
    field->open = true;
    Host host;
    settleInto(surface, host, view);
    EXPECT_EQ(host.cracks(), 0U);
}

TEST(Surface, cancelsWhatIsNoLongerWantedAndKeepsItsCacheBounded)
{
    SurfaceOptions options = smallOptions();
    options.cacheBytes = 200'000;
    Surface surface(
        std::make_shared<Hills>(),
        {},
        options,
        std::shared_ptr<core::Jobs>(core::makeJobs(core::JobsBackend::threads, 1)));
    Host host;
    auto generator = tests::random(71);
    for (int i = 0; i < 150; ++i) { // teleports
        const glm::dvec3 eye(
            tests::uniform(generator, 0.1, 0.9),
            tests::uniform(generator, 0.1, 0.9),
            tests::uniform(generator, 0.45, 0.9));
        host.apply(surface.update(viewFrom(eye), {.milliseconds = 1}));
        ASSERT_LE(surface.stats().cacheBytes, options.cacheBytes);
    }
    EXPECT_GT(surface.stats().cellsCancelled, 0U);

    // far away all detail goes
    settleInto(surface, host, viewFrom({1e6, 0, 0}));
    EXPECT_LE(surface.stats().frontCells, 48U);
    EXPECT_EQ(host.cracks(), 0U);
}

TEST(Surface, takesMeshesFromItsCacheWhenTheViewerComesBack)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    Host host;
    const hierarchy::View here = viewFrom({0.3, 0.3, 0.62});
    const hierarchy::View there = viewFrom({0.7, 0.7, 0.62});
    host.apply(surface.settle(here));
    settleInto(surface, host, there);
    const std::uint64_t before = surface.stats().cellsExtracted;
    const std::uint64_t cached = surface.stats().cellsFromCache;
    settleInto(surface, host, here);
    EXPECT_GT(surface.stats().cellsFromCache, cached + 100);
    EXPECT_LT(
        surface.stats().cellsExtracted - before, (surface.stats().cellsFromCache - cached) / 4);
    EXPECT_EQ(host.cracks(), 0U);
}

TEST(Surface, refusesViewsThatAreNotNumbers)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(surface.update(viewFrom({nan, 0, 0})).isEmpty());
    EXPECT_TRUE(surface.settle(viewFrom({0, nan, 0})).isEmpty());
    EXPECT_EQ(surface.stats().refusedViews, 2U);
    EXPECT_FALSE(surface.isSettled());
}

} // namespace
} // namespace isofront::surface
