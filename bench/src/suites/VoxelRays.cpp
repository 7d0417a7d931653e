// How fast rays find voxels, and what that takes, beside Embree's rays and the triangles that the
// voxels were made of.

#include "../EmbreeModel.h"
#include "Models.h"
#include "Suites.h"
#include "isofront/bench/Timing.h"

#include <isofront/core/Hash.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

using voxels::Ray;
using voxels::TriangleModel;

/// One ray for each pixel of a picture of the model.
std::vector<Ray> pictureRays(const core::Box& box, int width, int height)
{
    const double size = glm::length(box.size());
    const glm::dvec3 forward = glm::normalize(glm::dvec3(0.36, 0.80, -0.48));
    const glm::dvec3 right = glm::normalize(glm::cross(forward, glm::dvec3(0, 0, 1)));
    const glm::dvec3 down = glm::cross(forward, right);
    const glm::dvec3 eye = box.centre() - 1.3 * size * forward;
    const double step = 0.8 / width; // at distance 1
    std::vector<Ray> rays;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            rays.push_back(
                {eye,
                 glm::normalize(
                     forward + step * (x + 0.5 - 0.5 * width) * right +
                     step * (y + 0.5 - 0.5 * height) * down)});
    return rays;
}

/// Rays that have nothing to do with each other: between places around the model.
std::vector<Ray> scatteredRays(const core::Box& box, std::size_t count)
{
    const auto place = [&](std::uint64_t seed) {
        const auto number = [&](std::uint64_t i) {
            return static_cast<double>(core::mixed(4 * seed + i) >> 11U) * 0x1p-53;
        };
        const double z = 2 * number(1) - 1;
        const double phi = 2 * std::numbers::pi * number(2);
        const double r = std::sqrt(1 - z * z);
        return box.centre() +
               0.6 * glm::length(box.size()) * glm::dvec3(r * std::cos(phi), r * std::sin(phi), z);
    };
    std::vector<Ray> rays;
    for (std::uint64_t i = 0; i < count; ++i) {
        const glm::dvec3 from = place(2 * i + 1);
        rays.push_back({from, glm::normalize(place(2 * i + 2) - from)});
    }
    return rays;
}

Table rayTable()
{
    return {
        "voxel-rays",
        "Rays a second on one thread",
        {{"model", "", "what is looked at"},
         {"what", "", "level N: voxels of that level; triangles: Embree, those of the mesh"},
         {"resolution", "", "voxels of level 0 along the longest edge"},
         {"items", "", "voxels or triangles"},
         {"rays", "", "picture: one a pixel; scattered: through all of the model"},
         {"count", "", "of rays"},
         {"hits", "%", "of the rays"},
         {"rate", "Mrays/s", "processor time, the best of the runs"},
         {"memory", "bytes", "for each item, with what it is found by"},
         {"tree", "bytes", "of these, for finding it"},
         {"load",
          "ms",
          "to read the chunks and build what they are found by; for Embree, to build"},
         {"spread", "%", "of the runs"},
         {"runs", "", "timed runs"}},
        {},
        {}};
}

struct Subject {
    std::string name;
    TriangleModel model;
};

std::vector<Subject> subjects(const Context& context)
{
    std::vector<Subject> found;
    if (context.isFull())
        if (auto dragon = modelFile(context, kDragon))
            found.push_back({"dragon", std::move(*dragon)});
    if (found.empty())
        found.push_back({"hills", hills(context.pick(100U, 600U))});
    return found;
}

/// Millions a second.
double rateOf(const Timing& timing, std::size_t rays)
{
    return timing.least > 0 ? static_cast<double>(rays) / timing.least * 1e-6
                            : std::numeric_limits<double>::quiet_NaN();
}

/// How two casts of the same rays compare.
struct Agreement {
    std::size_t both = 0;
    std::size_t odd = 0; ///< met by one only
    double median = 0;   ///< between the two distances, of those that meet both [voxels]
};

Agreement agreementOf(
    const std::vector<std::optional<voxels::VoxelHit>>& hits,
    const std::vector<peers::EmbreeRay>& others,
    double edge)
{
    Agreement agreement;
    std::vector<double> apart;
    for (std::size_t i = 0; i < hits.size(); ++i) {
        const bool other = others[i].distance >= 0;
        if (hits[i].has_value() != other)
            ++agreement.odd;
        else if (other)
            apart.push_back(
                std::abs(hits[i]->distance - static_cast<double>(others[i].distance)) / edge);
    }
    agreement.both = apart.size();
    if (!apart.empty()) {
        std::ranges::nth_element(apart, apart.begin() + static_cast<long>(apart.size() / 2));
        agreement.median = apart[apart.size() / 2];
    }
    return agreement;
}

} // namespace

SuiteResult runVoxelRays(const Context& context)
{
    SuiteResult result;
    Table table = rayTable();
    constexpr double kSeconds = 3; // for one measurement
    const auto alone = core::makeJobs(core::JobsBackend::inlined);
    const auto add = [&](const std::string& model,
                         const std::string& what,
                         std::uint32_t resolution,
                         std::size_t items,
                         const std::string& kind,
                         std::size_t rays,
                         std::size_t hits,
                         const Timing& timing,
                         double bytes,
                         double tree,
                         double load) {
        table.add(
            {model,
             what,
             count(resolution),
             count(items),
             kind,
             count(rays),
             100.0 * static_cast<double>(hits) / static_cast<double>(rays),
             rateOf(timing, rays),
             bytes / static_cast<double>(items),
             tree / static_cast<double>(items),
             1e3 * load,
             100 * timing.spread,
             count(timing.runs)});
    };
    for (const Subject& subject : subjects(context)) {
        const core::Box box = boundsOf(subject.model);
        const std::vector<std::pair<std::string, std::vector<Ray>>> sets{
            {"picture", pictureRays(box, context.pick(120, 640), context.pick(90, 480))},
            {"scattered", scatteredRays(box, context.pick(10'000U, 300'000U))}};

        std::optional<EmbreeModel> embree;
        const Timing built = timed([&] { embree.emplace(subject.model, box.low); }, 1);
        std::vector<std::vector<peers::EmbreeRay>> triangleHits;
        for (const auto& [kind, rays] : sets) {
            if (context.isStopped() || !embree->isThere())
                break;
            context.say(subject.name + ", Embree, " + kind);
            std::vector<peers::EmbreeRay>& cast = triangleHits.emplace_back(embree->raysOf(rays));
            const Timing timing =
                timed([&] { embree->cast(cast, EmbreeModel::Way::single); }, 7, kSeconds);
            const auto hits = static_cast<std::size_t>(
                std::ranges::count_if(cast, [](const auto& ray) { return ray.distance >= 0; }));
            const auto bytes = static_cast<double>(embree->bytes());
            const auto mesh = static_cast<double>(
                12 * (subject.model.positions.size() + subject.model.triangles.size()));
            add(subject.name,
                "triangles",
                0,
                subject.model.triangles.size(),
                kind,
                rays.size(),
                hits,
                timing,
                bytes + mesh,
                bytes,
                built.least);
        }

        for (const std::uint32_t resolution : context.isFull()
                                                  ? std::vector<std::uint32_t>{512, 1024, 2048}
                                                  : std::vector<std::uint32_t>{300}) {
            if (context.isStopped())
                break;
            const auto made = inMemory(context, subject.name, subject.model, resolution);
            if (!made) {
                result.check(subject.name + " becomes voxels", false, made.error().message);
                continue;
            }
            const voxels::ChunkStore& store = **made;
            const voxels::VoxelLattice& lattice = store.model().lattice;
            std::vector<std::vector<std::optional<voxels::VoxelHit>>> finer;
            for (std::uint32_t level = 0; level < std::min(lattice.levels, 2U); ++level) {
                const auto caster =
                    voxels::VoxelRayCaster::create(store, voxels::cutOfLevel(store, level));
                if (!caster)
                    continue;
                std::size_t voxelCount = 0;
                for (const voxels::ChunkKey& key : voxels::cutOfLevel(store, level))
                    voxelCount += (*store.get(key))->voxels.size();
                for (std::size_t set = 0; set < sets.size(); ++set) {
                    const auto& [kind, rays] = sets[set];
                    if (context.isStopped())
                        break;
                    std::vector<std::optional<voxels::VoxelHit>> hits;
                    const auto cast = [&] { hits = *caster->cast(rays, *alone); };
                    const std::uint64_t before = caster->statistics().loads;
                    const Timing first = timed(cast, 1);
                    const bool loaded = caster->statistics().loads > before;
                    const Timing timing = timed(cast, 7, kSeconds);
                    const auto met = static_cast<std::size_t>(std::ranges::count_if(
                        hits, [](const auto& hit) { return hit.has_value(); }));
                    const voxels::RayCasterStatistics statistics = caster->statistics();
                    add(subject.name,
                        "level " + std::to_string(level),
                        resolution,
                        voxelCount,
                        kind,
                        rays.size(),
                        met,
                        timing,
                        static_cast<double>(statistics.bytes),
                        static_cast<double>(statistics.treeBytes),
                        loaded ? std::max(first.least - timing.least, 0.0)
                               : std::numeric_limits<double>::quiet_NaN());
                    if (level == 0 && set < triangleHits.size()) {
                        const Agreement agreement =
                            agreementOf(hits, triangleHits[set], lattice.edge);
                        result.check(
                            "voxels of " + subject.name + " at " + std::to_string(resolution) +
                                " are met where triangles are, " + kind,
                            agreement.median < 1 && 10 * agreement.odd < agreement.both,
                            std::to_string(agreement.both) + " rays meet both, " +
                                std::to_string(agreement.odd) + " one; " +
                                std::to_string(agreement.median) + " voxels apart, the median");
                    }
                    if (level == 0) {
                        finer.push_back(std::move(hits));
                        continue;
                    }
                    std::size_t behind = 0;
                    for (std::size_t i = 0; i < hits.size(); ++i)
                        if (const auto& fine = finer[set][i]; fine)
                            behind += hits[i] && hits[i]->distance <= fine->distance ? 0U : 1U;
                    result.check(
                        "level 1 of " + subject.name + " at " + std::to_string(resolution) +
                            " hides level 0, " + kind,
                        behind == 0,
                        std::to_string(behind) + " of " + std::to_string(hits.size()) +
                            " rays go deeper");
                }
            }
        }
    }
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench
