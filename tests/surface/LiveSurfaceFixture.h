#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Diamond.h>
#include <isofront/surface/Surface.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

namespace isofront::surface {

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

inline hierarchy::View viewFrom(const glm::dvec3& eye)
{
    hierarchy::View view;
    view.eye = eye;
    view.width = 320;
    view.height = 200;
    return view;
}

inline SurfaceOptions smallOptions()
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
        std::size_t removed = 0;
        std::size_t added = 0;
        for (const DeltaStep& step : delta.steps) {
            removed += step.removed;
            added += step.added;
            ASSERT_GT(step.removed + step.added, 0U);
        }
        ASSERT_EQ(removed, delta.removed.size());
        ASSERT_EQ(added, delta.added.size());
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

    /// Cells whose meshes aren't what an extractor makes of them.
    [[nodiscard]] std::size_t strangers(const extractor::CellExtractor& extractor) const
    {
        std::size_t count = 0;
        for (const auto& [id, mesh] : _cells) {
            const auto expected = extractor.extract(hierarchy::tetrahedronOf(id));
            count += mesh->vertices == expected->vertices && mesh->indices == expected->indices
                         ? 0U
                         : 1U;
        }
        return count;
    }

private:
    std::map<CellId, std::shared_ptr<const extractor::CellMesh>> _cells;
};

inline void settleInto(Surface& surface, Host& host, const hierarchy::View& view)
{
    for (int i = 0; i < 20000 && (i == 0 || !surface.isSettled()); ++i) {
        const Delta delta = surface.update(view, {.milliseconds = 20});
        host.apply(delta);
        if (delta.isEmpty())
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ASSERT_TRUE(surface.isSettled());
}

/// Updates until something changes.
inline Delta nextDelta(Surface& surface, const hierarchy::View& view)
{
    for (int i = 0; i < 20000; ++i) {
        Delta delta = surface.update(view, {.milliseconds = 1});
        if (!delta.isEmpty())
            return delta;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return {};
}

inline std::shared_ptr<core::Jobs> jobsOf(core::JobsBackend backend, std::size_t threads = 2)
{
    return core::makeJobs(backend, threads);
}

/// For tests that are run on every kind of jobs.
inline const auto kBackends = testing::Values(
    core::JobsBackend::inlined, core::JobsBackend::threads, core::JobsBackend::automatic);

inline std::string backendName(const testing::TestParamInfo<core::JobsBackend>& parameter)
{
    return parameter.param == core::JobsBackend::inlined   ? "inlined"
           : parameter.param == core::JobsBackend::threads ? "threads"
                                                           : "automatic";
}

} // namespace isofront::surface
