// A viewer who jumps, and levels that are skipped for him.

#include "LiveSurfaceFixture.h"
#include "support/Random.h"

#include <array>
#include <iterator>
#include <set>

namespace isofront::surface {
namespace {

std::set<CellId> idsOf(const Host& host)
{
    std::set<CellId> ids;
    for (const auto& [id, mesh] : host.cells())
        ids.insert(id);
    return ids;
}

SurfaceOptions skipping()
{
    SurfaceOptions options = smallOptions();
    options.skipLevels = true;
    return options;
}

std::set<CellId> fromNothing(const SurfaceOptions& options, const hierarchy::View& view)
{
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    host.apply(surface.settle(view));
    return idsOf(host);
}

extractor::CellExtractor extractorOf(double isovalue)
{
    extractor::ExtractionSettings settings = smallOptions().extraction;
    settings.isovalue = isovalue;
    return {std::make_shared<Hills>(), {}, settings};
}

class JumpOnJobs : public testing::TestWithParam<core::JobsBackend> {};

TEST_P(JumpOnJobs, skipsTheLevelsBetweenAndEndsTheSame)
{
    const hierarchy::View far = viewFrom({0.5, 0.5, 4});
    const hierarchy::View near = viewFrom({0.4, 0.3, 0.62});
    std::array<std::uint64_t, 2> extracted{};
    for (const bool skips : {false, true}) {
        SurfaceOptions options = smallOptions();
        options.skipLevels = skips;
        Surface surface(std::make_shared<Hills>(), {}, options, jobsOf(GetParam()));
        Host host;
        settleInto(surface, host, far);
        const SurfaceStats before = surface.stats();
        std::size_t triangles = 0;
        for (int i = 0; i < 20000 && (i == 0 || !surface.isSettled()); ++i) {
            // time enough to know the whole wanted front at once, on however slow a machine: what
            // is asked for before that is known may be for levels that would have been skipped
            const Delta delta = surface.update(near, {.milliseconds = skips ? 60'000.0 : 20.0});
            if (delta.isEmpty()) {
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
                continue;
            }
            host.apply(delta);
            ASSERT_EQ(host.cracks(), 0U);
            triangles = std::max(triangles, host.triangles());
        }
        extracted[skips ? 1 : 0] = surface.stats().cellsExtracted - before.cellsExtracted;
        if (skips) {
            EXPECT_LE(surface.stats().deltas - before.deltas, 4U);
        }
        EXPECT_EQ(surface.stats().triangles, host.triangles());
        EXPECT_EQ(idsOf(host), fromNothing(smallOptions(), near));
        EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
        EXPECT_LE(triangles, host.triangles() + host.triangles() / 4) << "never finer than wanted";

        // and back, with what was there before
        const std::uint64_t cached = surface.stats().cellsFromCache;
        settleInto(surface, host, far);
        EXPECT_EQ(idsOf(host), fromNothing(smallOptions(), far));
        EXPECT_GT(surface.stats().cellsFromCache, cached);
    }
    EXPECT_LT(extracted[1], extracted[0] * 2 / 3);
}

TEST_P(JumpOnJobs, canBeFollowedByAnythingAtAnyTime)
{
    auto generator = tests::random(111);
    const auto somewhere = [&] {
        return glm::dvec3(
            tests::uniform(generator, 0.1, 0.9),
            tests::uniform(generator, 0.1, 0.9),
            tests::uniform(generator, 0.56, 0.8));
    };
    SurfaceOptions options = skipping();
    options.pixelError = 3;
    options.cacheBytes = 1'000'000;
    Surface surface(std::make_shared<Hills>(), {}, options, jobsOf(GetParam()));
    Host host;
    double isovalue = 0;
    glm::dvec3 eye = somewhere();
    std::size_t mostBytes = 0;
    std::size_t mostMeshes = 0;
    for (int i = 0; i < tests::trials(120); ++i) {
        switch (tests::below(generator, 8)) {
        case 0:
            isovalue = std::round(tests::uniform(generator, -10, 20)) / 1000;
            surface.setIsovalue(isovalue);
            break;
        case 1:
            surface.setDetail(tests::uniform(generator, 2.5, 6), options.detail);
            break;
        case 2:
        case 3:
            eye = somewhere();
            break;
        default:
            eye += 0.02 * (somewhere() - glm::dvec3(0.5, 0.5, 0.68));
        }
        host.apply(surface.update(viewFrom(eye), {.milliseconds = 10}));
        if (tests::below(generator, 3) == 0)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
        if (i % 8 == 0) {
            ASSERT_EQ(host.cracks(), 0U) << i;
        }
        ASSERT_EQ(surface.stats().triangles, host.triangles());
        const SurfaceStats stats = surface.stats();
        mostBytes = std::max(mostBytes, stats.totalBytes - stats.hierarchyBytes);
        mostMeshes = std::max(mostMeshes, stats.meshBytes);
    }
    surface.setDetail(options.pixelError, options.detail);
    settleInto(surface, host, viewFrom(eye));
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_EQ(host.strangers(extractorOf(isovalue)), 0U);
    options.extraction.isovalue = isovalue;
    EXPECT_EQ(idsOf(host), fromNothing(options, viewFrom(eye)));
    EXPECT_LE(mostBytes, 6 * mostMeshes + 2 * options.cacheBytes);
}

INSTANTIATE_TEST_SUITE_P(Backends, JumpOnJobs, kBackends, backendName);

TEST(Jump, leavesWhatCanStayAsFineAsItIs)
{
    // Where much of what is wanted is shown already, it doesn't become coarser for a while.
    SurfaceOptions options = skipping();
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    const hierarchy::View first = viewFrom({0.3, 0.3, 0.62});
    const hierarchy::View second = viewFrom({0.5, 0.3, 0.62});
    host.apply(surface.settle(first));
    const std::set<CellId> before = idsOf(host);
    const std::set<CellId> after = fromNothing(options, second);
    std::set<CellId> staying;
    std::ranges::set_intersection(before, after, std::inserter(staying, staying.end()));
    ASSERT_GT(staying.size(), before.size() / 4);
    for (int i = 0; i < 20000 && (i == 0 || !surface.isSettled()); ++i) {
        const Delta delta = surface.update(second, {.milliseconds = 50});
        host.apply(delta);
        if (delta.isEmpty()) {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            continue;
        }
        for (const CellId& id : staying)
            ASSERT_TRUE(host.cells().contains(id));
    }
    EXPECT_EQ(idsOf(host), after);
}

} // namespace
} // namespace isofront::surface
