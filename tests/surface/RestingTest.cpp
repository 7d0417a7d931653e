#include "LiveSurfaceFixture.h"
#include "support/Random.h"

#include <chrono>
#include <set>
#include <thread>

namespace isofront::surface {
namespace {

std::set<CellId> idsOf(const Host& host)
{
    std::set<CellId> ids;
    for (const auto& [id, mesh] : host.cells())
        ids.insert(id);
    return ids;
}

/// What a surface that has seen nothing else shows for a view.
std::set<CellId> fromNothing(const SurfaceOptions& options, const hierarchy::View& view)
{
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    host.apply(surface.settle(view));
    return idsOf(host);
}

glm::dvec3 somewhere(std::mt19937_64& generator)
{
    return {
        tests::uniform(generator, 0.1, 0.9),
        tests::uniform(generator, 0.1, 0.9),
        tests::uniform(generator, 0.5, 0.9)};
}

SurfaceOptions measuredOptions()
{
    SurfaceOptions options = smallOptions();
    options.pixelError = 3;
    options.detail.measuredLevels = 6;
    return options;
}

class RestingOnJobs : public testing::TestWithParam<core::JobsBackend> {};

TEST_P(RestingOnJobs, endsAsASurfaceThatHasSeenNothingElse)
{
    auto generator = tests::random(91);
    for (const int measuredLevels : {0, 6}) {
        SurfaceOptions options = measuredOptions();
        options.detail.measuredLevels = measuredLevels;
        options.cacheBytes = 300'000; // so that some is lost on the way
        Surface surface(std::make_shared<Hills>(), {}, options, jobsOf(GetParam()));
        Host host;
        for (int trial = 0; trial < 3 * tests::intensity(); ++trial) {
            // a history of its own: steps, jumps, other isovalues, other detail
            glm::dvec3 eye = somewhere(generator);
            for (int i = 0; i < 12; ++i) {
                eye = tests::below(generator, 5) == 0
                          ? somewhere(generator)
                          : eye + 0.02 * (somewhere(generator) - glm::dvec3(0.5));
                if (tests::below(generator, 6) == 0)
                    surface.setIsovalue(tests::uniform(generator, -0.02, 0.04));
                if (tests::below(generator, 8) == 0)
                    surface.setDetail(tests::uniform(generator, 2, 8), options.detail);
                host.apply(surface.update(viewFrom(eye), {.milliseconds = 3}));
            }
            ASSERT_EQ(host.cracks(), 0U);
            options.extraction.isovalue = std::round(tests::uniform(generator, 0, 20)) / 1000;
            surface.setIsovalue(options.extraction.isovalue);
            surface.setDetail(options.pixelError, options.detail);
            settleInto(surface, host, viewFrom(eye));
            EXPECT_EQ(host.cracks(), 0U);
            EXPECT_EQ(idsOf(host), fromNothing(options, viewFrom(eye)))
                << "trial " << trial << ", " << measuredLevels << " levels measured";
            EXPECT_TRUE(surface.update(viewFrom(eye)).isEmpty());
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, RestingOnJobs, kBackends, backendName);

TEST(Resting, leavesLessWhereTheSurfaceIsFlatAndAsMuchWhereItIsNot)
{
    // a plate: flat above and below, so that all detail is wasted
    class Plate final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(0.4 + 0.1 * batch.x[i] - batch.z[i]);
        }
        [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval) const override
        {
            return {
                0.4 + 0.1 * box.low.x - box.high.z - 1e-6,
                0.4 + 0.1 * box.high.x - box.low.z + 1e-6};
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
    };
    SurfaceOptions options = measuredOptions();
    const hierarchy::View view = viewFrom({0.5, 0.4, 0.6});
    const auto trianglesOf = [&](std::shared_ptr<const fields::Field> field, int levels) {
        options.detail.measuredLevels = levels;
        Surface surface(std::move(field), {}, options);
        surface.settle(view);
        return surface.stats().triangles;
    };
    // A cell without triangles that isn't proved empty is not believed, so part of it stays fine.
    const std::size_t flat = trianglesOf(std::make_shared<Plate>(), 0);
    EXPECT_LT(trianglesOf(std::make_shared<Plate>(), 6), flat * 2 / 5);
    EXPECT_LT(trianglesOf(std::make_shared<Plate>(), 3), flat * 3 / 5);
    // never more than without measuring
    const std::size_t hilly = trianglesOf(std::make_shared<Hills>(), 0);
    EXPECT_LE(trianglesOf(std::make_shared<Hills>(), 6), hilly);
}

TEST(Resting, beginsToMeasureErrorsWhenItIsAskedTo)
{
    SurfaceOptions options = measuredOptions();
    const DetailSettings measured = options.detail;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    const std::set<CellId> expected = fromNothing(options, view);
    options.detail = {};
    // with a surface at rest, and with operations under way and in a change of the isovalue
    for (const int how : {0, 3}) {
        Surface surface(std::make_shared<Hills>(), {}, options);
        Host host;
        host.apply(surface.settle(how == 0 ? view : viewFrom({0.7, 0.6, 0.6})));
        for (int i = 0; i < how; ++i)
            host.apply(surface.update(view, {.milliseconds = 1}));
        if (how == 3) {
            surface.setIsovalue(0.01);
            host.apply(surface.update(view, {.milliseconds = 1}));
        }
        surface.setDetail(options.pixelError, measured);
        surface.setIsovalue(0);
        settleInto(surface, host, view);
        EXPECT_EQ(idsOf(host), expected) << how;
        EXPECT_EQ(host.cracks(), 0U);
    }
}

TEST(Resting, givesBackMemoryAfterManyTeleports)
{
    SurfaceOptions options = measuredOptions();
    options.pixelError = 8;
    options.cacheBytes = 500'000;
    Surface surface(std::make_shared<Hills>(), {}, options, jobsOf(core::JobsBackend::threads));
    Host host;
    const hierarchy::View home = viewFrom({0.4, 0.3, 0.65});
    settleInto(surface, host, home);
    const std::set<CellId> before = idsOf(host);
    const std::size_t bytes = surface.stats().meshBytes;

    auto generator = tests::random(92);
    const int teleports = 1000 * tests::intensity();
    for (int i = 0; i < teleports; ++i) {
        glm::dvec3 eye = somewhere(generator);
        if (i % 50 == 25)
            eye = glm::dvec3(1e12, -1e12, 1e12);
        if (i % 50 == 26)
            eye = glm::dvec3(0);
        host.apply(surface.update(viewFrom(eye), {.milliseconds = 0.5}));
        ASSERT_LE(surface.stats().cacheBytes, options.cacheBytes);
        ASSERT_LT(surface.stats().totalBytes, 64U << 20U);
        if (i % 50 == 0) {
            ASSERT_EQ(host.cracks(), 0U) << "teleport " << i;
        }
    }
    settleInto(surface, host, home);
    EXPECT_EQ(idsOf(host), before);
    EXPECT_EQ(surface.stats().meshBytes, bytes);
    // What is no longer wanted is given up slice by slice, and what runs ends at its next look.
    for (int i = 0; i < 5000 && surface.stats().pendingCells > 0; ++i) {
        EXPECT_TRUE(surface.update(home, {.milliseconds = 0.5}).isEmpty());
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_EQ(surface.stats().pendingCells, 0U);
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_LT(surface.stats().hierarchyBytes, 64U << 20U);
}

TEST(Resting, hasStepsThatCanBeTakenOneByOne)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    Host host;
    auto generator = tests::random(93);
    std::size_t steps = 0;
    std::size_t largest = 0;
    // However slow the machine is, until enough has been seen.
    for (int i = 0; i < 12 || (i < 1000 && (steps < 32 || largest < 2)); ++i) {
        const glm::dvec3 eye = somewhere(generator);
        for (int update = 0; update < 4; ++update) {
            const Delta delta = surface.update(viewFrom(eye), {.milliseconds = 5});
            largest = std::max(largest, delta.steps.size());
            auto removed = delta.removed.begin();
            auto added = delta.added.begin();
            for (const DeltaStep& step : delta.steps) {
                Delta part;
                const auto gone = removed + static_cast<std::ptrdiff_t>(step.removed);
                const auto come = added + static_cast<std::ptrdiff_t>(step.added);
                part.removed.assign(removed, gone);
                part.added.assign(added, come);
                part.steps = {step};
                host.apply(part);
                removed = gone;
                added = come;
                // each alone leaves no crack; now and then is enough
                if (++steps % 16 == 0) {
                    ASSERT_EQ(host.cracks(), 0U) << "step " << steps;
                }
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    EXPECT_GE(steps, 32U);
    EXPECT_GT(largest, 1U);
    EXPECT_EQ(host.cracks(), 0U);
}

} // namespace
} // namespace isofront::surface
