#include "LiveSurfaceFixture.h"
#include "support/Random.h"

#include <set>

namespace isofront::surface {
namespace {

struct Ceilings {
    std::size_t cells = std::numeric_limits<std::size_t>::max();
    std::size_t triangles = std::numeric_limits<std::size_t>::max();
    std::size_t bytes = std::numeric_limits<std::size_t>::max();
};

SurfaceOptions under(const Ceilings& ceilings)
{
    SurfaceOptions options = smallOptions();
    options.maxCells = ceilings.cells;
    options.maxTriangles = ceilings.triangles;
    options.maxBytes = ceilings.bytes;
    return options;
}

class CeilingsOnJobs : public testing::TestWithParam<core::JobsBackend> {};

TEST_P(CeilingsOnJobs, areNeverExceededAndLeaveACrackFreeFront)
{
    auto generator = tests::random(101);
    for (const Ceilings& ceilings :
         {Ceilings{.cells = 3000},
          Ceilings{.triangles = 9000},
          Ceilings{.bytes = 3'000'000},
          Ceilings{.cells = 2500, .triangles = 20000, .bytes = 8'000'000}}) {
        Surface surface(std::make_shared<Hills>(), {}, under(ceilings), jobsOf(GetParam()));
        Host host;
        glm::dvec3 eye(0.5, 0.4, 0.65);
        for (int i = 0; i < 20; ++i) {
            eye = i % 7 == 6 ? glm::dvec3(0.3, 0.7, 0.6)
                             : eye + glm::dvec3(0.01, tests::uniform(generator, -0.02, 0.02), 0);
            host.apply(surface.update(viewFrom(eye), {.milliseconds = 5}));
            ASSERT_LE(surface.stats().frontCells, ceilings.cells);
            ASSERT_LE(surface.stats().triangles, ceilings.triangles);
            ASSERT_EQ(host.cracks(), 0U);
        }
        settleInto(surface, host, viewFrom(eye));
        const SurfaceStats stats = surface.stats();
        EXPECT_LE(stats.frontCells, ceilings.cells);
        EXPECT_LE(stats.triangles, ceilings.triangles);
        EXPECT_LE(stats.totalBytes, ceilings.bytes);
        EXPECT_GT(stats.effectivePixelError, smallOptions().pixelError);
        EXPECT_EQ(host.cracks(), 0U);
        EXPECT_GT(host.triangles(), 500U) << "a front, if a coarser one";
        // and no further change
        for (int i = 0; i < 20; ++i)
            EXPECT_TRUE(surface.update(viewFrom(eye), {.milliseconds = 5}).isEmpty());
        EXPECT_TRUE(surface.isSettled());
    }
}

INSTANTIATE_TEST_SUITE_P(Backends, CeilingsOnJobs, kBackends, backendName);

TEST(Ceilings, leaveTheFinestFrontThatFits)
{
    const hierarchy::View view = viewFrom({0.5, 0.4, 0.65});
    // every factor of the row, each on its own, tells which is the first that fits
    for (const Ceilings& ceilings : {Ceilings{.cells = 4000}, Ceilings{.triangles = 12000}}) {
        double expected = 0;
        for (int step = 0; expected == 0; ++step) {
            SurfaceOptions options = smallOptions();
            options.pixelError *= std::exp2(step / 8.0);
            options.maxLevel -= static_cast<int>(3 * (step / 8.0));
            options.extraction.cornerRadius = 1e-3; // doesn't depend on the finest level
            Surface surface(std::make_shared<Hills>(), {}, options);
            surface.settle(view);
            if (surface.stats().frontCells <= ceilings.cells &&
                surface.stats().triangles <= ceilings.triangles)
                expected = options.pixelError;
        }
        Surface direct(std::make_shared<Hills>(), {}, under(ceilings));
        Host host;
        host.apply(direct.settle(view));
        EXPECT_TRUE(direct.isSettled());
        EXPECT_NEAR(direct.stats().effectivePixelError, expected, 1e-9);
        EXPECT_LE(direct.stats().triangles, ceilings.triangles);

        // the same step by step, from here and from a place that leaves more or less
        Surface stepwise(std::make_shared<Hills>(), {}, under(ceilings));
        Host other;
        for (const glm::dvec3& eye : {glm::dvec3(0.3, 0.8, 0.58), glm::dvec3(0.5, 0.5, 3.0)}) {
            settleInto(stepwise, other, viewFrom(eye));
            settleInto(stepwise, other, view);
            EXPECT_NEAR(stepwise.stats().effectivePixelError, expected, 1e-9);
            EXPECT_EQ(other.triangles(), host.triangles());
        }
    }
}

TEST(Ceilings, countWhatTheHostHolds)
{
    const hierarchy::View view = viewFrom({0.5, 0.4, 0.65});
    Surface surface(std::make_shared<Hills>(), {}, under({.bytes = 20'000'000}));
    Host host;
    const auto settleHolding = [&](std::size_t bytes) {
        for (int i = 0; i < 20000 && (i < 3 || !surface.isSettled()); ++i) {
            host.apply(surface.update(view, {.milliseconds = 20, .hostBytes = bytes}));
            std::this_thread::sleep_for(std::chrono::microseconds(200));
        }
        return surface.stats().triangles;
    };
    const std::size_t alone = settleHolding(0);
    EXPECT_LT(settleHolding(18'000'000), alone);
    EXPECT_LE(surface.stats().totalBytes, 20'000'000U);
    EXPECT_EQ(host.cracks(), 0U);
}

TEST(Ceilings, holdWhenAnotherIsovalueHasMoreOfASurface)
{
    // drops at the higher isovalue, which flow together into sheets at the lower one
    class Drops final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < batch.size(); ++i)
                values[i] = static_cast<float>(
                    std::sin(40 * batch.x[i]) * std::sin(40 * batch.y[i]) *
                    std::sin(40 * batch.z[i]));
        }
        [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
        {
            return {-1.0, 1.0};
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }
    };
    constexpr double kDrops = 0.8;
    constexpr double kSheets = 0.05;
    const hierarchy::View view = viewFrom({0.5, 0.5, 1.3});
    SurfaceOptions options = smallOptions();
    options.pixelError = 4;
    options.maxLevel = 12;
    const auto made = [&](double isovalue, const Ceilings& ceilings) {
        options.extraction.isovalue = isovalue;
        options.maxTriangles = ceilings.triangles;
        options.maxBytes = ceilings.bytes;
        return Surface(std::make_shared<Drops>(), {}, options, jobsOf(core::JobsBackend::threads));
    };
    Surface free = made(kDrops, {});
    free.settle(view);
    const SurfaceStats drops = free.stats();
    for (const Ceilings& ceilings :
         {Ceilings{.triangles = drops.triangles * 3 / 2},
          Ceilings{.bytes = drops.totalBytes - drops.cacheBytes + drops.meshBytes * 3 / 2}}) {
        Surface surface = made(kDrops, ceilings);
        surface.settle(view);
        ASSERT_EQ(surface.stats().triangles, drops.triangles) << "the drops fit";
        surface.setIsovalue(kSheets);
        for (int i = 0; i < 20000 && (i == 0 || !surface.isSettled()); ++i) {
            if (surface.update(view, {.milliseconds = 10}).isEmpty())
                std::this_thread::sleep_for(std::chrono::milliseconds(1));
            ASSERT_LE(surface.stats().triangles, ceilings.triangles);
        }
        ASSERT_TRUE(surface.isSettled());
        EXPECT_LE(surface.stats().totalBytes, ceilings.bytes);
        Surface other = made(kSheets, ceilings);
        other.settle(view);
        EXPECT_EQ(surface.stats().triangles, other.stats().triangles);
    }
}

} // namespace
} // namespace isofront::surface
