#include "LiveSurfaceFixture.h"
#include "support/Random.h"

#include <atomic>
#include <limits>
#include <set>

namespace isofront::surface {
namespace {

extractor::CellExtractor extractorOf(double isovalue)
{
    extractor::ExtractionSettings settings = smallOptions().extraction;
    settings.isovalue = isovalue;
    return {std::make_shared<Hills>(), {}, settings};
}

std::set<CellId> idsOf(const Host& host)
{
    std::set<CellId> ids;
    for (const auto& [id, mesh] : host.cells())
        ids.insert(id);
    return ids;
}

class IsovalueOnJobs : public testing::TestWithParam<core::JobsBackend> {};

TEST_P(IsovalueOnJobs, changesTheWholeSurfaceInOneDeltaAndKeepsItsFront)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions(), jobsOf(GetParam()));
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    settleInto(surface, host, view);
    const std::size_t cells = surface.stats().frontCells;

    surface.setIsovalue(0.02);
    EXPECT_EQ(surface.isovalue(), 0.02);
    EXPECT_FALSE(surface.isSettled());
    Delta delta;
    for (int i = 0; i < 20000 && delta.isEmpty(); ++i) {
        delta = surface.update(view, {.milliseconds = 1});
        if (delta.isEmpty()) {
            ASSERT_EQ(surface.stats().frontCells, cells);
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }
    EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
    EXPECT_EQ(delta.isovalue, 0.02);
    host.apply(delta);
    EXPECT_EQ(surface.stats().frontCells, cells);
    EXPECT_EQ(surface.stats().triangles, host.triangles());
    EXPECT_EQ(host.strangers(extractorOf(0.02)), 0U);
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_GT(delta.steps.size(), 100U) << "each diamond replaces its own cells";

    // and ends as a surface that has never been another
    settleInto(surface, host, view);
    SurfaceOptions options = smallOptions();
    options.extraction.isovalue = 0.02;
    Surface other(std::make_shared<Hills>(), {}, options);
    Host fresh;
    fresh.apply(other.settle(view));
    EXPECT_EQ(idsOf(host), idsOf(fresh));
    EXPECT_EQ(host.strangers(extractorOf(0.02)), 0U);
}

TEST_P(IsovalueOnJobs, showsOneIsovalueAtATimeWhileItIsAnimated)
{
    SurfaceOptions options = smallOptions();
    options.cacheBytes = 4'000'000;
    Surface surface(std::make_shared<Hills>(), {}, options, jobsOf(GetParam()));
    Host host;
    auto generator = tests::random(81);
    settleInto(surface, host, viewFrom({0.4, 0.3, 0.7}));
    double isovalue = 0;
    std::size_t changes = 0;
    std::size_t mostBytes = 0;
    for (int frame = 0; frame < 50; ++frame) {
        // a slider that is pulled, rests now and then, and a viewer who goes on meanwhile
        if (frame % 10 < 7)
            isovalue = std::round(tests::uniform(generator, -30, 60)) / 1000;
        surface.setIsovalue(isovalue);
        const hierarchy::View view = viewFrom({0.4 + 0.001 * frame, 0.3, 0.7});
        const Delta delta =
            frame % 10 == 9 ? nextDelta(surface, view) : surface.update(view, {.milliseconds = 2});
        mostBytes = std::max(mostBytes, surface.stats().totalBytes);
        if (delta.isEmpty())
            continue;
        ++changes;
        host.apply(delta);
        ASSERT_EQ(host.cracks(), 0U) << "frame " << frame;
        if (changes % 8 == 0) {
            ASSERT_EQ(host.strangers(extractorOf(delta.isovalue)), 0U) << "frame " << frame;
        }
    }
    EXPECT_GE(changes, 5U);
    settleInto(surface, host, viewFrom({0.5, 0.3, 0.7}));
    EXPECT_EQ(host.strangers(extractorOf(isovalue)), 0U) << "the last one wins";
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_LE(surface.stats().cacheBytes, options.cacheBytes);
    EXPECT_LT(mostBytes, 100'000'000U);
}

INSTANTIATE_TEST_SUITE_P(Backends, IsovalueOnJobs, kBackends, backendName);

TEST(Isovalue, isTestedAgainstStoredBoundsWithoutASample)
{
    class Counted final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            samples += batch.size();
            Hills().sample(batch, values);
        }
        [[nodiscard]] core::Interval
        bounds(const core::Box& box, core::Interval radius) const override
        {
            ++asked;
            return Hills().bounds(box, radius);
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
        mutable std::atomic<std::size_t> samples{0};
        mutable std::atomic<std::size_t> asked{0};
    };
    const auto field = std::make_shared<Counted>();
    Surface surface(field, {}, smallOptions());
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    settleInto(surface, host, view);
    const std::size_t samples = field->samples;
    const std::size_t asked = field->asked;
    ASSERT_GT(samples, 0U);

    // no bounds of any diamond of the front reach so high
    surface.setIsovalue(100);
    host.apply(nextDelta(surface, view));
    EXPECT_TRUE(host.cells().empty());
    EXPECT_EQ(field->samples, samples);
    EXPECT_LT(field->asked, asked + 100) << "what is known isn't asked for again";
}

TEST(Isovalue, neverMakesAnUpdateWait)
{
    // a field that doesn't answer until it is allowed to
    class Stuck final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            while (!open)
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            Hills().sample(batch, values);
        }
        [[nodiscard]] core::Interval
        bounds(const core::Box& box, core::Interval radius) const override
        {
            return Hills().bounds(box, radius);
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
        std::atomic<bool> open{true};
    };
    const auto field = std::make_shared<Stuck>();
    Surface surface(field, {}, smallOptions(), jobsOf(core::JobsBackend::threads));
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    settleInto(surface, host, view);
    field->open = false;
    for (int i = 0; i < 10; ++i) { // would hang here
        surface.setIsovalue(0.01 + 0.001 * i);
        EXPECT_TRUE(surface.update(view).isEmpty());
    }
    EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
    field->open = true;
    settleInto(surface, host, view);
    EXPECT_EQ(host.strangers(extractorOf(0.019)), 0U);
}

TEST(Isovalue, isShownOnACoarserFrontFirstIfAskedFor)
{
    SurfaceOptions options = smallOptions();
    options.coarseFirst = 3;
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    settleInto(surface, host, view);
    const std::set<CellId> before = idsOf(host);
    const std::size_t triangles = host.triangles();
    surface.setIsovalue(0.001);
    host.apply(nextDelta(surface, view));
    EXPECT_LT(host.triangles(), triangles / 2);
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_EQ(host.strangers(extractorOf(0.001)), 0U);
    settleInto(surface, host, view);
    EXPECT_GT(host.triangles(), triangles * 9 / 10);
    EXPECT_EQ(host.cracks(), 0U);
}

TEST(Isovalue, canBeTakenBackAndIsRefusedIfItIsNotANumber)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    surface.setIsovalue(0.01); // before anything is on show
    surface.update(view);
    surface.setIsovalue(0);
    settleInto(surface, host, view);
    EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
    const std::set<CellId> before = idsOf(host);

    surface.setIsovalue(0.05);
    host.apply(surface.update(view));
    surface.setIsovalue(0);
    settleInto(surface, host, view);
    EXPECT_EQ(idsOf(host), before);
    EXPECT_EQ(host.strangers(extractorOf(0)), 0U);

    surface.setIsovalue(std::numeric_limits<double>::quiet_NaN());
    surface.setIsovalue(std::numeric_limits<double>::infinity());
    EXPECT_EQ(surface.stats().refusedIsovalues, 2U);
    EXPECT_EQ(surface.isovalue(), 0);
    EXPECT_TRUE(surface.isSettled());

    // all at once, too
    surface.setIsovalue(0.03);
    host.apply(surface.settle(view));
    EXPECT_TRUE(surface.isSettled());
    EXPECT_EQ(host.strangers(extractorOf(0.03)), 0U);
    EXPECT_EQ(host.cracks(), 0U);
}

/// The surface that has seen nothing but a view at an isovalue.
std::set<CellId> fromNothing(SurfaceOptions options, double isovalue, const hierarchy::View& view)
{
    options.extraction.isovalue = isovalue;
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    host.apply(surface.settle(view));
    return idsOf(host);
}

TEST(Isovalue, canGoBackAndForthFasterThanTheSurfaceFollows)
{
    // two changes between two updates, of which the second is to what is being gone back to
    SurfaceOptions options = smallOptions();
    options.pixelError = 4;
    const auto jobs = jobsOf(core::JobsBackend::threads);
    const hierarchy::View first = viewFrom({0.4, 0.3, 0.7});
    const hierarchy::View second = viewFrom({0.7, 0.6, 0.6});
    const std::set<CellId> expected = fromNothing(options, 0, second);
    for (int updates = 0; updates < 5; ++updates) {
        Surface surface(std::make_shared<Hills>(), {}, options, jobs);
        Host host;
        host.apply(surface.settle(first));
        // operations are under way
        host.apply(surface.update(second, {.milliseconds = 1}));
        surface.setIsovalue(0.03);
        host.apply(surface.update(second));
        surface.setIsovalue(0);
        for (int i = 0; i < updates; ++i) {
            std::this_thread::sleep_for(std::chrono::milliseconds(4));
            host.apply(surface.update(second, {.milliseconds = 1}));
        }
        surface.setIsovalue(0.02);
        surface.setIsovalue(0);
        settleInto(surface, host, second);
        EXPECT_EQ(host.cracks(), 0U);
        EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
        EXPECT_EQ(idsOf(host), expected) << updates;
    }
}

TEST(Isovalue, extractsNothingAgainOnTheWayBack)
{
    Surface surface(std::make_shared<Hills>(), {}, smallOptions());
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    settleInto(surface, host, view);
    surface.setIsovalue(0.02);
    host.apply(nextDelta(surface, view));
    // at once, while all is where it was, and when some or all of it is in the cache
    double isovalue = 0.02;
    for (const int updates : {0, 1, 2, 30}) {
        settleInto(surface, host, view);
        for (int back = 0; back < 2; ++back) {
            for (int i = 0; i < updates; ++i)
                host.apply(surface.update(view, {.milliseconds = 0.05}));
            const std::uint64_t samples = surface.stats().samples;
            const std::uint64_t cached = surface.stats().cellsFromCache;
            isovalue = 0.02 - isovalue;
            surface.setIsovalue(isovalue);
            host.apply(nextDelta(surface, view));
            // but for cells that another front has brought meanwhile
            if (back == 1 || updates == 0) {
                EXPECT_EQ(surface.stats().samples, samples) << updates << " updates";
            }
            EXPECT_GT(surface.stats().cellsFromCache, cached + 100);
            EXPECT_EQ(host.strangers(extractorOf(isovalue)), 0U);
            EXPECT_EQ(host.cracks(), 0U);
        }
    }
}

TEST(Isovalue, keepsItsMemoryWithinBoundsWhileItChangesWithoutAPause)
{
    // another one as soon as one is there, so that there is never time to put meshes away
    SurfaceOptions options = smallOptions();
    options.pixelError = 4;
    options.cacheBytes = 3'000'000;
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    host.apply(surface.settle(view));
    std::size_t most = 0;
    std::size_t meshes = 0;
    for (int change = 1; change <= 40; ++change) {
        surface.setIsovalue(0.0005 * change);
        host.apply(nextDelta(surface, view));
        const SurfaceStats stats = surface.stats();
        most = std::max(most, stats.totalBytes - stats.hierarchyBytes);
        meshes = std::max(meshes, stats.meshBytes);
    }
    EXPECT_GT(40 * meshes, 4 * options.cacheBytes) << "or it is no test";
    EXPECT_LE(most, meshes + 2 * options.cacheBytes);
    EXPECT_EQ(host.strangers(extractorOf(0.02)), 0U);
}

TEST(Isovalue, leavesNoTraceOfAChangeThatWasStoppedHalfWay)
{
    SurfaceOptions options = smallOptions();
    options.pixelError = 3;
    options.detail.measuredLevels = 6;
    Surface surface(std::make_shared<Hills>(), {}, options);
    Host host;
    const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
    host.apply(surface.settle(view));
    surface.setIsovalue(0.03);
    std::stop_source source;
    EXPECT_TRUE(surface
                    .settle(
                        view,
                        [&](double share) {
                            if (share > 0.2)
                                source.request_stop();
                        },
                        source.get_token())
                    .isEmpty());
    ASSERT_TRUE(source.stop_requested());
    surface.setIsovalue(0);
    const hierarchy::View other = viewFrom({0.5, 0.4, 0.68});
    settleInto(surface, host, other);
    EXPECT_EQ(host.cracks(), 0U);
    EXPECT_EQ(host.strangers(extractorOf(0)), 0U);
    EXPECT_EQ(idsOf(host), fromNothing(options, 0, other));
}

} // namespace
} // namespace isofront::surface
