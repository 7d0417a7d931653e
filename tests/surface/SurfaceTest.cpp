#include "support/FunctionField.h"
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

/// Hills with a wall around: a closed body, so that any open edge is a crack; and with honest
/// bounds, so that cells without surface are skipped.
class Hills final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(value({batch.x[i], batch.y[i], batch.z[i]}));
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval) const override
    {
        const double middle = value(box.centre());
        const double reach = 3.0 * glm::length(box.size()) / 2 + 1e-6; // slope at most 3
        return {middle - reach, middle + reach};
    }
    [[nodiscard]] double differenceStep(double) const override { return 1e-4; }

    static double value(const glm::dvec3& p)
    {
        const double height = 0.5 + 0.08 * std::sin(9 * p.x) * std::cos(7 * p.y) +
                              0.02 * std::sin(31 * p.x + 17 * p.y);
        const glm::dvec3 d = glm::abs(p - glm::dvec3(0.5));
        return std::min({height - p.z, 0.45 - d.x, 0.45 - d.y, p.z - 0.07});
    }
};

hierarchy::View viewFrom(const glm::dvec3& eye)
{
    hierarchy::View view;
    view.eye = eye;
    view.width = 320;
    view.height = 200;
    return view;
}

SurfaceOptions smallOptions()
{
    SurfaceOptions options;
    options.extraction.latticeSize = 4;
    options.extraction.filterStrength = 0;
    options.pixelError = 2.0;
    options.maxLevel = 15;
    return options;
}

/// What a host holds: it knows deltas and nothing else.
class Host {
public:
    void apply(const Delta& delta)
    {
        for (const CellId& id : delta.removed)
            ASSERT_EQ(_cells.erase(id), 1U) << "removed what wasn't there";
        for (const ShownCell& cell : delta.added) {
            ASSERT_NE(cell.mesh(), nullptr);
            ASSERT_GT(cell.mesh()->triangleCount(), 0U);
            ASSERT_TRUE(_cells.emplace(cell.id, cell.mesh()).second) << "added twice";
        }
    }
    /// Edges that don't belong to exactly two triangles which run along them in opposite ways.
    /// Joined by position on the grid: a closed surface has none.
    [[nodiscard]] std::size_t cracks() const
    {
        struct Use {
            std::uint64_t edge; ///< a hash of both ends
            int direction;
        };
        std::vector<Use> uses;
        for (const auto& [id, mesh] : _cells) {
            std::vector<std::uint64_t> end;
            for (const extractor::CellVertex& vertex : mesh->vertices) {
                const hierarchy::GridPoint p = mesh->gridPosition(vertex);
                std::uint64_t hash = 0;
                for (const std::int64_t coordinate : {p.x, p.y, p.z})
                    hash = core::hashCombined(hash, static_cast<std::uint64_t>(coordinate));
                end.push_back(hash);
            }
            for (std::size_t i = 0; i < mesh->indices.size(); i += 3)
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint64_t a = end[mesh->indices[i + k]];
                    const std::uint64_t b = end[mesh->indices[i + (k + 1) % 3]];
                    uses.push_back(
                        {core::hashCombined(std::min(a, b), std::max(a, b)), a < b ? 1 : -1});
                }
        }
        std::ranges::sort(uses, {}, &Use::edge);
        std::size_t bad = 0;
        for (std::size_t first = 0, last = 0; first < uses.size(); first = last) {
            int sum = 0;
            for (; last < uses.size() && uses[last].edge == uses[first].edge; ++last)
                sum += uses[last].direction;
            bad += sum != 0 ? 1U : 0U;
        }
        return bad;
    }
    [[nodiscard]] std::size_t triangles() const
    {
        std::size_t sum = 0;
        for (const auto& [id, mesh] : _cells)
            sum += mesh->triangleCount();
        return sum;
    }
    [[nodiscard]] const std::map<CellId, std::shared_ptr<const extractor::CellMesh>>& cells() const
    {
        return _cells;
    }

private:
    std::map<CellId, std::shared_ptr<const extractor::CellMesh>> _cells;
};

/// A flight over the hills, with a turn back and a jump.
glm::dvec3 flightAt(int frame)
{
    const double t = frame / 60.0;
    if (frame >= 40 && frame < 50)
        return {0.15, 0.85, 0.62};
    return {0.2 + 0.6 * (t < 0.5 ? t : 1 - t), 0.3 + 0.4 * t, 0.66 + 0.05 * std::sin(9 * t)};
}

void settleInto(Surface& surface, Host& host, const hierarchy::View& view)
{
    for (int i = 0; i < 20000 && (i == 0 || !surface.isSettled()); ++i) {
        const Delta delta = surface.update(view, {.milliseconds = 20});
        host.apply(delta);
        if (delta.isEmpty())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(surface.isSettled());
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

INSTANTIATE_TEST_SUITE_P(
    Backends,
    SurfaceOnJobs,
    testing::Values(
        core::JobsBackend::inlined, core::JobsBackend::threads, core::JobsBackend::automatic),
    [](const auto& parameter) {
        return parameter.param == core::JobsBackend::inlined   ? "inlined"
               : parameter.param == core::JobsBackend::threads ? "threads"
                                                               : "automatic";
    });

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
