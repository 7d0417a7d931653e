#include "ChunkOccupancy.h"
#include "LatticeRay.h"
#include "Models.h"
#include "support/Random.h"

#include <isofront/voxels/VoxelRay.h>
#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <set>

namespace isofront::voxels {
namespace {

__extension__ using Wide = __int128;
using Cube = std::array<std::int64_t, 3>;

/// A ray in whole numbers, moved by so little that it meets no edge and no corner: multiplied by
/// 2^60 and moved by 2^40, 2^20 and 1. For starts and directions of a few bits that is as little as
/// nothing; for long ones, that meet no edges, `kAsItIs`.
struct MovedRay {
    static constexpr Wide kMoved = Wide{1} << 60;
    static constexpr Wide kAsItIs = 1;

    std::array<Wide, 3> start;
    Cube direction;
    Wide unit;

    MovedRay(const Cube& from, const Cube& along, Wide scale) : direction(along), unit(scale)
    {
        for (std::size_t i = 0; i < 3; ++i)
            start[i] = from[i] * scale + (scale > 1 ? Wide{1} << (40 - 20 * i) : 0);
    }
};

/// A moment on a ray: numerator and positive denominator.
struct Moment {
    Wide rise;
    std::int64_t size;

    friend bool operator<(const Moment& a, const Moment& b)
    {
        return a.rise * b.size < b.rise * a.size;
    }
};

struct Crossing {
    Moment enter;
    Moment exit;
    std::size_t axis; ///< of the face that it enters by
};

/// By the definition: where the ray is in a cube, from the start of time on.
std::optional<Crossing> crossing(const MovedRay& ray, const Cube& low, std::int64_t edge)
{
    Crossing result{{-(Wide{1} << 90), 1}, {Wide{1} << 90, 1}, LatticeRay::kNoAxis};
    for (std::size_t i = 0; i < 3; ++i) {
        const Wide below = low[i] * ray.unit - ray.start[i];
        const Wide above = (low[i] + edge) * ray.unit - ray.start[i];
        if (ray.direction[i] == 0) {
            if (below > 0 || above <= 0)
                return std::nullopt;
            continue;
        }
        const bool up = ray.direction[i] > 0;
        const std::int64_t size = std::abs(ray.direction[i]);
        const Moment enter{up ? below : -above, size};
        const Moment exit{up ? above : -below, size};
        if (result.enter < enter) {
            result.enter = enter;
            result.axis = i;
        }
        if (exit < result.exit)
            result.exit = exit;
    }
    if (!(result.enter < result.exit) || result.exit.rise <= 0)
        return std::nullopt;
    if (result.enter.rise <= 0) { // it starts inside
        result.enter = {0, 1};
        result.axis = LatticeRay::kNoAxis;
    }
    return result;
}

TEST(LatticeRay, entersTheCubesThatARayMovedByNothingEnters)
{
    constexpr int kCellBits = 3;
    constexpr int kQuarterBits = LatticeRay::kBits - kCellBits - 2;
    auto random = tests::random(70);
    const auto number = [&](int low, int high) {
        return low + static_cast<std::int64_t>(
                         tests::below(random, static_cast<std::size_t>(high - low + 1)));
    };
    std::size_t cubes = 0;
    std::size_t ties = 0;
    const int trials = tests::trials(5000);
    for (int trial = 0; trial < trials; ++trial) {
        Cube start{number(-8, 40), number(-8, 40), number(-8, 40)};
        const Cube direction{number(-4, 4), number(-4, 4), number(-4, 4)};
        if (direction == Cube{})
            continue;
        if (trial % 2 == 0)
            for (std::int64_t& s : start)
                s = s / 4 * 4; // on edges and corners
        const MovedRay moved(start, direction, MovedRay::kMoved);
        struct Step {
            Crossing crossing;
            Cube cell;
        };
        std::vector<Step> expected;
        for (std::int64_t z = 0; z < 8; ++z)
            for (std::int64_t y = 0; y < 8; ++y)
                for (std::int64_t x = 0; x < 8; ++x)
                    if (const auto c = crossing(moved, {4 * x, 4 * y, 4 * z}, 4))
                        expected.push_back({*c, {x, y, z}});
        std::ranges::sort(expected, [](const Step& a, const Step& b) {
            return a.crossing.enter < b.crossing.enter;
        });

        Cube steps{};
        for (std::size_t i = 0; i < 3; ++i)
            steps[i] = start[i] * (std::int64_t{1} << kQuarterBits);
        const LatticeRay ray(steps, direction, kCellBits);
        auto place = ray.begin();
        for (const Step& step : expected) {
            ASSERT_TRUE(place);
            ASSERT_TRUE(ray.contains(*place));
            for (std::size_t i = 0; i < 3; ++i)
                ASSERT_EQ(place->cell[i], step.cell[i]) << "trial " << trial;
            ASSERT_EQ(place->axis, step.crossing.axis);
            const double before = ray.distance(*place);
            ray.leave(*place, 0);
            ASSERT_GE(ray.distance(*place), before);
            ties += ray.distance(*place) == before ? 1U : 0U;
            ++cubes;
        }
        ASSERT_TRUE(!place || !ray.contains(*place)) << "trial " << trial;
    }
    if (trials >= 1000) {
        EXPECT_GT(cubes, 10'000U);
        EXPECT_GT(ties, 1000U);
    }
}

TEST(LatticeRay, leapsOverCubesOfAnySizeToWhereStepsLead)
{
    auto random = tests::random(71);
    for (int trial = 0; trial < tests::trials(2000); ++trial) {
        Cube start{};
        Cube direction{};
        const bool small = trial % 2 == 0; // with ties
        for (std::size_t i = 0; i < 3; ++i) {
            start[i] = small ? static_cast<std::int64_t>(tests::below(random, 513)) << 21U
                             : static_cast<std::int64_t>(tests::below(random, 1U << 30U));
            direction[i] =
                small ? static_cast<std::int64_t>(tests::below(random, 7)) - 3
                      : static_cast<std::int64_t>(tests::below(random, 1U << 31U)) - (1 << 30);
        }
        if (direction == Cube{})
            continue;
        const LatticeRay ray(start, direction, 8);
        auto leaping = ray.begin();
        auto stepping = leaping;
        while (leaping && ray.contains(*leaping)) {
            const auto bits = static_cast<int>(tests::below(random, 7));
            const auto from = leaping->cell;
            ray.leave(*leaping, bits);
            const auto isInside = [&] {
                for (std::size_t i = 0; i < 3; ++i)
                    if ((stepping->cell[i] ^ from[i]) >> bits != 0)
                        return false;
                return true;
            };
            while (isInside())
                ray.leave(*stepping, 0);
            ASSERT_EQ(leaping->cell, stepping->cell);
            ASSERT_EQ(leaping->axis, stepping->axis);
            ASSERT_EQ(leaping->rise, stepping->rise);
        }
    }
}

TEST(ChunkOccupancy, tellsTheLargestEmptyCubeAroundAnyPlace)
{
    auto random = tests::random(72);
    for (const std::size_t count : {0U, 1U, 2U, 60U, 5000U}) {
        std::set<std::uint32_t> orders;
        for (std::size_t i = 0; i < count; ++i) {
            // in clusters, so that there is empty space of all sizes
            const auto base = static_cast<std::uint32_t>(tests::below(random, 7)) * 0x1f2b3dU;
            const auto near = static_cast<std::uint32_t>(random()) & 0x1f0f07U;
            orders.insert((base + near) & 0xffffffU);
        }
        std::vector<Voxel> voxels;
        for (const std::uint32_t order : orders)
            voxels.push_back({order, 0});
        const ChunkOccupancy occupancy(voxels);
        for (int trial = 0; trial < tests::trials(3000); ++trial) {
            auto order = static_cast<std::uint32_t>(tests::below(random, 1U << 24U));
            if (trial % 2 == 0 && !voxels.empty()) // near one
                order = (voxels[tests::below(random, voxels.size())].order() +
                         static_cast<std::uint32_t>(tests::below(random, 4)) * 0x010101U) &
                        0xffffffU;
            const Voxel place{order, 0};
            int expected = ChunkOccupancy::kFullCube;
            for (int bits = 0; bits <= 8; ++bits) {
                const auto isIn = [&](const Voxel& v) {
                    return v.x() >> bits == place.x() >> bits &&
                           v.y() >> bits == place.y() >> bits && v.z() >> bits == place.z() >> bits;
                };
                if (std::ranges::any_of(voxels, isIn))
                    break;
                expected = bits;
            }
            ASSERT_EQ(occupancy.emptyAround(place.x(), place.y(), place.z()), expected);
        }
    }
    const ChunkOccupancy none(std::span<const Voxel>{});
    EXPECT_EQ(none.emptyAround(1, 2, 3), 8);
}

/// Voxels by hand, and all coarser levels of them, with the index of a voxel as its colour.
std::unique_ptr<ChunkStore> storeOf(std::set<Cube> cubes, std::uint32_t levels)
{
    auto store = memoryStore();
    for (std::uint32_t level = 0; level < levels; ++level) {
        std::map<ChunkKey, std::set<std::uint32_t>> chunks;
        std::set<Cube> parents;
        for (const Cube& c : cubes) {
            const auto at = [&](std::size_t i) { return static_cast<std::uint32_t>(c[i]); };
            chunks[{level, at(0) >> 8U, at(1) >> 8U, at(2) >> 8U}].insert(
                packPlace(at(0) & 255U, at(1) & 255U, at(2) & 255U, kAllFaces));
            parents.insert({c[0] / 2, c[1] / 2, c[2] / 2});
        }
        for (const auto& [key, places] : chunks) {
            Chunk chunk{key, {}, {}};
            for (const std::uint32_t place : places) {
                chunk.colours.push_back(static_cast<std::uint32_t>(chunk.voxels.size()));
                chunk.voxels.push_back({place, packNormal(glm::dvec3(1, 2, 3))});
            }
            EXPECT_FALSE(store->put(std::move(chunk)));
        }
        cubes = std::move(parents);
    }
    StoredModel model;
    model.name = "by hand";
    model.lattice.resolution = kChunkEdge << (levels - 1);
    model.lattice.levels = levels;
    EXPECT_FALSE(store->finish(model));
    return store;
}

/// A cut with levels by chance.
ChunkCut randomCut(const ChunkStore& store, std::mt19937_64& random)
{
    const std::vector<ChunkKey> keys = store.keys();
    const std::set<ChunkKey> all(keys.begin(), keys.end());
    ChunkCut cut;
    const std::function<void(const ChunkKey&)> visit = [&](const ChunkKey& key) {
        if (!all.contains(key))
            return;
        if (key.level == 0 || tests::below(random, 3) == 0) {
            cut.push_back(key);
            return;
        }
        for (std::uint32_t which = 0; which < 8; ++which)
            visit(key.child(which));
    };
    const std::uint32_t top = store.model().lattice.levels - 1;
    if (top == 0)
        return keys;
    for (std::uint32_t which = 0; which < 8; ++which)
        visit(ChunkKey{top, 0, 0, 0}.child(which));
    return cut;
}

VoxelRayCaster
casterOf(const ChunkStore& store, const ChunkCut& cut, const RayCasterSettings& settings = {})
{
    auto caster = VoxelRayCaster::create(store, cut, settings);
    EXPECT_TRUE(caster) << caster.error().message;
    return std::move(*caster);
}

TEST(VoxelRayCaster, findsWhatALookAtAllVoxelsFinds)
{
    // three levels, 1024 cells along an edge; starts in quarters of a cell, or in steps
    constexpr std::uint32_t kLevels = 3;
    auto random = tests::random(73);
    std::set<Cube> cubes;
    for (int i = 0; i < 400; ++i) {
        const Cube base{
            static_cast<std::int64_t>(tests::below(random, 4)) * 256,
            static_cast<std::int64_t>(tests::below(random, 2)) * 512,
            static_cast<std::int64_t>(tests::below(random, 3)) * 255};
        Cube cube{};
        for (std::size_t axis = 0; axis < 3; ++axis)
            cube[axis] = std::min<std::int64_t>(
                1023, base[axis] + static_cast<std::int64_t>(tests::below(random, 12)));
        cubes.insert(cube);
    }
    const auto store = storeOf(cubes, kLevels);
    std::size_t hits = 0;
    std::size_t inside = 0;
    for (int round = 0; round < 4; ++round) {
        const ChunkCut cut = randomCut(*store, random);
        const VoxelRayCaster caster = casterOf(*store, cut);
        struct Known {
            Cube low;
            std::int64_t edge;
            VoxelHit hit;
        };
        std::vector<Known> all;
        for (const ChunkKey& key : cut) {
            const Chunk chunk = **store->get(key);
            for (std::uint32_t i = 0; i < chunk.voxels.size(); ++i) {
                const Voxel& v = chunk.voxels[i];
                Known known{{}, std::int64_t{1} << key.level, {}};
                known.hit.chunk = key;
                known.hit.index = i;
                known.hit.place = {key.x << 8U | v.x(), key.y << 8U | v.y(), key.z << 8U | v.z()};
                for (std::size_t axis = 0; axis < 3; ++axis)
                    known.low[axis] = std::int64_t{known.hit.place[axis]} << key.level;
                all.push_back(known);
            }
        }
        for (int trial = 0; trial < tests::trials(600); ++trial) {
            const Known& target = all[tests::below(random, all.size())];
            const bool small = trial % 2 == 0;
            Ray ray;
            Cube start{};
            Cube direction{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                if (small) { // through corners, along edges
                    direction[axis] = static_cast<std::int64_t>(tests::below(random, 9)) - 4;
                    start[axis] = 4 * target.low[axis] +
                                  static_cast<std::int64_t>(tests::below(random, 5)) -
                                  direction[axis] * static_cast<std::int64_t>(4 * (trial % 9));
                    ray.start[axis] = 0.25 * static_cast<double>(start[axis]);
                    ray.direction[axis] = static_cast<double>(direction[axis]);
                } else {
                    ray.start[axis] = tests::uniform(random, -300, 1500);
                    const double to = static_cast<double>(target.low[axis]) +
                                      tests::uniform(random, 0, static_cast<double>(target.edge));
                    ray.direction[axis] = to - ray.start[axis];
                }
            }
            double longest = 0;
            for (std::size_t axis = 0; axis < 3; ++axis)
                longest = std::max(longest, std::abs(ray.direction[axis]));
            if (small && longest != 1 && longest != 2 && longest != 4)
                continue; // others aren't exact once they are rounded
            std::int64_t unit = 4;
            if (!small) {
                unit = 1 << 20;
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    start[axis] = std::llround(ray.start[axis] * static_cast<double>(unit));
                    direction[axis] =
                        std::llround(ray.direction[axis] / longest * (std::int64_t{1} << 30));
                }
            }
            const MovedRay moved(start, direction, small ? MovedRay::kMoved : MovedRay::kAsItIs);
            const Known* first = nullptr;
            std::optional<Crossing> earliest;
            for (const Known& known : all) {
                Cube low = known.low;
                for (std::int64_t& l : low)
                    l *= unit;
                const auto c = crossing(moved, low, known.edge * unit);
                if (c && (!earliest || c->enter < earliest->enter)) {
                    earliest = c;
                    first = &known;
                }
            }
            const auto hit = caster.cast(ray);
            ASSERT_TRUE(hit);
            ASSERT_EQ(hit->has_value(), first != nullptr) << "trial " << trial;
            if (first == nullptr)
                continue;
            ++hits;
            inside += (*hit)->face ? 0U : 1U;
            ASSERT_EQ((*hit)->chunk, first->hit.chunk) << "trial " << trial;
            ASSERT_EQ((*hit)->index, first->hit.index) << "trial " << trial;
            ASSERT_EQ((*hit)->place, first->hit.place);
            ASSERT_EQ((*hit)->colour, first->hit.index);
            ASSERT_EQ((*hit)->face.has_value(), earliest->axis != LatticeRay::kNoAxis);
            if ((*hit)->face) {
                ASSERT_EQ(static_cast<std::size_t>(*(*hit)->face) / 2, earliest->axis);
                ASSERT_EQ(
                    static_cast<std::size_t>(*(*hit)->face) % 2 == 0,
                    direction[earliest->axis] > 0);
            }
            const double expected =
                static_cast<double>(earliest->enter.rise) / static_cast<double>(moved.unit) /
                static_cast<double>(earliest->enter.size) / static_cast<double>(unit) *
                std::hypot(direction[0], direction[1], direction[2]);
            ASSERT_NEAR(
                (*hit)->distance, expected, 1e-12 * (expected + 1) + 1e-5 * (small ? 1 : 0));
        }
    }
    EXPECT_GT(hits, 10U);
    if (tests::trials(600) >= 600) {
        EXPECT_GT(hits, 1000U);
        EXPECT_GT(inside, 30U);
    }
}

struct Sphere {
    std::unique_ptr<ChunkStore> store = memoryStore();
    VoxelizationReport report;
};

const Sphere& hillySphere()
{
    static const Sphere sphere = [] {
        Sphere made;
        const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
        const auto report =
            voxelize(tests::hillySphere(60, 10, 1.5), {.resolution = 600}, *made.store, *jobs);
        EXPECT_TRUE(report);
        made.report = *report;
        StoredModel model;
        model.lattice = report->lattice;
        EXPECT_FALSE(made.store->finish(model));
        return made;
    }();
    return sphere;
}

glm::dvec3 randomDirection(std::mt19937_64& random)
{
    for (;;) {
        glm::dvec3 d(0);
        for (std::size_t i = 0; i < 3; ++i)
            d[i] = tests::uniform(random, -1, 1);
        const double squared = glm::dot(d, d);
        if (squared > 0.01 && squared < 1)
            return d / std::sqrt(squared);
    }
}

/// From inside the sphere in all directions; some along axes and diagonals, and from edges of
/// cubes.
std::vector<Ray> raysFromInside(std::size_t count, std::mt19937_64& random)
{
    const VoxelLattice& lattice = hillySphere().report.lattice;
    std::vector<Ray> rays(count);
    for (std::size_t i = 0; i < count; ++i) {
        rays[i].start = tests::uniform(random, 0, 7) * randomDirection(random);
        rays[i].direction = randomDirection(random);
        if (i % 4 == 0) { // on the lattice
            rays[i].start =
                lattice.origin +
                glm::round((rays[i].start - lattice.origin) / lattice.edge) * lattice.edge;
            for (std::size_t axis = 0; axis < 3; ++axis)
                rays[i].direction[axis] = static_cast<double>(tests::below(random, 3)) - 1;
            if (rays[i].direction == glm::dvec3(0))
                rays[i].direction.x = 1;
        }
    }
    return rays;
}

TEST(VoxelRayCaster, letsNoRayOutOfAClosedModelAtAnyMixOfLevels)
{
    auto random = tests::random(74);
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    const ChunkStore& store = *hillySphere().store;
    ASSERT_EQ(hillySphere().report.lattice.levels, 3U);
    for (int round = 0; round < 6; ++round) {
        const ChunkCut cut = round < 3 ? cutOfLevel(store, static_cast<std::uint32_t>(round))
                                       : randomCut(store, random);
        const VoxelRayCaster caster = casterOf(store, cut);
        std::vector<Ray> rays =
            raysFromInside(static_cast<std::size_t>(tests::trials(14'000)), random);
        const auto out = caster.cast(rays, *jobs);
        ASSERT_TRUE(out);
        std::size_t leaks = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
            leaks += (*out)[i] ? 0U : 1U;
            // and back in, from far away
            rays[i].start += 1000.0 * rays[i].direction;
            rays[i].direction = -rays[i].direction;
            rays[i].reach = 999.0 * glm::length(rays[i].direction);
        }
        EXPECT_EQ(leaks, 0U);
        const auto in = caster.cast(rays, *jobs);
        ASSERT_TRUE(in);
        for (const auto& hit : *in)
            leaks += hit ? 0U : 1U;
        EXPECT_EQ(leaks, 0U);
    }
}

TEST(VoxelRayCaster, hitsACoarserLevelWhereAFinerOneIsHitOrBefore)
{
    auto random = tests::random(75);
    const ChunkStore& store = *hillySphere().store;
    std::vector<Ray> rays = raysFromInside(static_cast<std::size_t>(tests::trials(10'000)), random);
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (i % 2 == 0) // past the sphere, too
            rays[i].start = 20.0 * randomDirection(random);
        else if (i % 3 == 0)
            rays[i] = {15.0 * rays[i].direction, -rays[i].direction};
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    std::vector<std::vector<std::optional<VoxelHit>>> hits;
    for (std::uint32_t level = 0; level < 3; ++level) {
        auto cast = casterOf(store, cutOfLevel(store, level)).cast(rays, *jobs);
        ASSERT_TRUE(cast);
        hits.push_back(std::move(*cast));
    }
    std::size_t equal = 0;
    std::size_t nearer = 0;
    for (std::size_t level = 1; level < 3; ++level)
        for (std::size_t i = 0; i < rays.size(); ++i) {
            const auto& fine = hits[level - 1][i];
            const auto& coarse = hits[level][i];
            if (!fine)
                continue;
            ASSERT_TRUE(coarse);
            ASSERT_LE(coarse->distance, fine->distance);
            (coarse->distance == fine->distance ? equal : nearer) += 1;
        }
    EXPECT_GT(equal, 0U);
    EXPECT_GT(nearer, 0U);
    // what is hit from outside shows the face that is hit
    for (std::size_t i = 0; i < rays.size(); ++i)
        if (const auto& hit = hits[0][i]; hit && glm::length(rays[i].start) > 14) {
            ASSERT_TRUE(hit->face);
            const Chunk chunk = **store.get(hit->chunk);
            ASSERT_NE(chunk.voxels[hit->index].faces() & faceBit(*hit->face), 0);
        }
}

TEST(VoxelRayCaster, givesTheSameForAxesInAnyOrder)
{
    auto random = tests::random(76);
    std::set<Cube> cubes;
    for (int i = 0; i < 3000; ++i)
        cubes.insert(
            {static_cast<std::int64_t>(tests::below(random, 64)),
             static_cast<std::int64_t>(tests::below(random, 300)),
             static_cast<std::int64_t>(tests::below(random, 200))});
    const auto straight = storeOf(cubes, 2);
    constexpr std::array<std::array<std::size_t, 3>, 5> kOrders{
        {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
    for (const auto& order : kOrders) {
        std::set<Cube> turned;
        for (const Cube& c : cubes)
            turned.insert({c[order[0]], c[order[1]], c[order[2]]});
        const auto other = storeOf(turned, 2);
        const std::uint32_t level = order[0] % 2;
        const VoxelRayCaster a = casterOf(*straight, cutOfLevel(*straight, level));
        const VoxelRayCaster b = casterOf(*other, cutOfLevel(*other, level));
        std::size_t hits = 0;
        for (int trial = 0; trial < tests::trials(300); ++trial) {
            Ray ray;
            Ray turnedRay;
            ray.direction = randomDirection(random);
            for (std::size_t axis = 0; axis < 3; ++axis)
                ray.start[axis] = tests::uniform(random, -10, 310);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                turnedRay.start[axis] = ray.start[order[axis]];
                turnedRay.direction[axis] = ray.direction[order[axis]];
            }
            const auto first = *a.cast(ray);
            const auto second = *b.cast(turnedRay);
            ASSERT_EQ(first.has_value(), second.has_value());
            if (!first)
                continue;
            ++hits;
            EXPECT_DOUBLE_EQ(first->distance, second->distance);
            for (std::size_t axis = 0; axis < 3; ++axis)
                EXPECT_EQ(second->place[axis], first->place[order[axis]]);
        }
        EXPECT_GT(hits, 0U);
    }
}

TEST(VoxelRayCaster, meetsABoxWhereItsFacesAre)
{
    // a solid box from (3, 5, 250) to (40, 20, 262), over two chunks
    std::set<Cube> cubes;
    for (std::int64_t z = 250; z < 262; ++z)
        for (std::int64_t y = 5; y < 20; ++y)
            for (std::int64_t x = 3; x < 40; ++x)
                cubes.insert({x, y, z});
    const auto store = storeOf(cubes, 2);
    const VoxelRayCaster caster = casterOf(*store, cutOfLevel(*store, 0));
    auto random = tests::random(77);
    std::size_t hits = 0;
    for (int trial = 0; trial < tests::trials(2000); ++trial) {
        Ray ray;
        for (std::size_t i = 0; i < 3; ++i)
            ray.start[i] = tests::uniform(random, -20, 300);
        const glm::dvec3 to(
            tests::uniform(random, 0, 43),
            tests::uniform(random, 3, 22),
            tests::uniform(random, 248, 264));
        ray.direction = 7.0 * (to - ray.start);
        double enter = 0;
        double exit = std::numeric_limits<double>::infinity();
        const glm::dvec3 unit = glm::normalize(ray.direction);
        const glm::dvec3 low(3, 5, 250);
        const glm::dvec3 high(40, 20, 262);
        for (std::size_t i = 0; i < 3; ++i) {
            const double a = (low[i] - ray.start[i]) / unit[i];
            const double b = (high[i] - ray.start[i]) / unit[i];
            enter = std::max(enter, std::min(a, b));
            exit = std::min(exit, std::max(a, b));
        }
        const auto hit = *caster.cast(ray);
        if (exit - enter > 1e-5) {
            ASSERT_TRUE(hit);
            EXPECT_NEAR(hit->distance, enter, 2e-5);
            EXPECT_EQ(hit->face.has_value(), enter > 0);
            ++hits;
            Ray shorter = ray;
            shorter.reach = 0.999 * hit->distance;
            EXPECT_EQ((*caster.cast(shorter)).has_value(), enter == 0);
        } else if (enter - exit > 1e-5) {
            EXPECT_FALSE(hit);
        }
    }
    EXPECT_GT(hits, 0U);
}

TEST(VoxelRayCaster, takesRaysFromAnywhereAndRefusesNonsense)
{
    const auto store = storeOf({{0, 0, 0}, {255, 255, 255}}, 1);
    const VoxelRayCaster caster = casterOf(*store, store->keys());
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    for (const Ray& ray :
         {Ray{{0, 0, 0}, {0, 0, 0}},
          Ray{{kNone, 0, 0}, {1, 0, 0}},
          Ray{{0, 0, 0}, {1, kNone, 0}},
          Ray{{0, kInfinite, 0}, {1, 0, 0}},
          Ray{{0, 0, 0}, {1, 0, -kInfinite}},
          Ray{{0, 0, 0}, {1, 0, 0}, kNone}}) {
        const auto hit = caster.cast(ray);
        ASSERT_FALSE(hit);
        EXPECT_EQ(hit.error().code, core::ErrorCode::usage);
    }
    const auto distance = [&](const Ray& ray) {
        const auto hit = caster.cast(ray);
        EXPECT_TRUE(hit);
        return hit && *hit ? (*hit)->distance : -1.0;
    };
    // inside, on its low faces, on its high faces looking in and away
    EXPECT_EQ(distance({{0.5, 0.5, 0.5}, {1, 1, 1}}), 0);
    EXPECT_EQ(distance({{0, 0, 0}, {-1, -1, -1}}), 0);
    EXPECT_EQ(distance({{1, 0.5, 0.5}, {-1, 0, 0}}), 0);
    EXPECT_EQ(distance({{1, 0.5, 0.5}, {1, 0, 0}}), -1);
    EXPECT_EQ(distance({{1, 1, 1}, {1, 1, 1}}), std::sqrt(3.0) * 254);
    EXPECT_EQ(distance({{256, 256, 256}, {-1, -1, -1}}), 0);
    // any length of direction, and any distance
    EXPECT_EQ(distance({{-100, 0.5, 0.5}, {1e-300, 0, 0}}), 100);
    EXPECT_EQ(distance({{-100, 0.5, 0.5}, {1e300, 0, 0}}), 100);
    EXPECT_DOUBLE_EQ(distance({{-1e9, 0.5, 0.5}, {1, 0, 0}}), 1e9);
    EXPECT_DOUBLE_EQ(distance({{0.5, 1e15, 0.5}, {0, -1, 0}}), 1e15 - 1);
    EXPECT_EQ(distance({{1e300, 1e300, 0.5}, {1, 1, 0}}), -1);
    EXPECT_EQ(distance({{-1e9, 0.5, 0.5}, {-1, 0, 0}}), -1);
    EXPECT_EQ(distance({{-1e9, 0.5, 0.5}, {0, 1, 0}}), -1);
    EXPECT_EQ(distance({{-1e300, 0.5, 0.5}, {1, 1, 1}, 10}), -1);
    EXPECT_EQ(distance({{-100, 0.5, 0.5}, {1, 0, 0}, 100}), 100);
    EXPECT_EQ(distance({{-100, 0.5, 0.5}, {1, 0, 0}, 99.99}), -1);
}

TEST(VoxelRayCaster, tellsTheAttributesOfTheFaceThatIsHit)
{
    const auto store = memoryStore();
    const std::uint32_t up = packNormal(glm::dvec3(0, 0, 1));
    const std::uint32_t left = packNormal(glm::dvec3(-1, 0, 0));
    const unsigned mask = faceBit(Face::lowX);
    EXPECT_FALSE(store->put(
        {{0, 0, 0, 0},
         {{packPlace(1, 1, 1, kAllFaces), up}, {packPlace(9, 9, 9, kAllFaces), up}},
         {7, 8},
         {{1, mask << 26U}},
         {{left, 70}}}));
    StoredModel model;
    model.lattice.resolution = 256;
    EXPECT_FALSE(store->finish(model));
    const VoxelRayCaster caster = casterOf(*store, store->keys());
    const auto colour = [&](const glm::dvec3& start, const glm::dvec3& direction) {
        const auto hit = *caster.cast({start, direction});
        EXPECT_EQ(hit->normal, unpackNormal(*hit->colour == 70 ? left : up));
        return *hit->colour;
    };
    EXPECT_EQ(colour({-1, 1.5, 1.5}, {1, 0, 0}), 7U);
    EXPECT_EQ(colour({-1, 9.5, 9.5}, {1, 0, 0}), 70U);
    EXPECT_EQ(colour({20, 9.5, 9.5}, {-1, 0, 0}), 8U);
    EXPECT_EQ(colour({9.5, 9.5, 9.5}, {-1, 0, 0}), 8U) << "from inside";
}

TEST(VoxelRayCaster, refusesCutsThatOverlapOrNameWhatIsNotThere)
{
    const auto store = storeOf({{3, 3, 3}, {300, 3, 3}, {700, 3, 3}}, 3);
    const auto code = [&](const ChunkCut& cut) {
        const auto caster = VoxelRayCaster::create(*store, cut);
        return caster ? 0 : static_cast<int>(caster.error().code);
    };
    EXPECT_EQ(code({}), 0);
    EXPECT_EQ(code({{0, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}}), 0);
    EXPECT_EQ(code({{0, 0, 0, 0}, {1, 0, 0, 0}}), 2);
    EXPECT_EQ(code({{1, 0, 0, 0}, {0, 0, 0, 0}}), 2);
    EXPECT_EQ(code({{0, 1, 0, 0}, {0, 1, 0, 0}}), 2);
    EXPECT_EQ(code({{0, 0, 1, 0}}), 2);
    EXPECT_EQ(code({{0, 4, 0, 0}}), 2);
    EXPECT_EQ(code({{3, 0, 0, 0}}), 2);
    EXPECT_EQ(code({{0xffffffffU, 0, 0, 0}}), 2);
    const VoxelRayCaster none = casterOf(*store, {});
    EXPECT_FALSE(*none.cast({{-1, 3.5, 3.5}, {1, 0, 0}}));
}

/// Counts what is read, and can't read one chunk.
class PoorStore : public ChunkStore {
public:
    explicit PoorStore(const ChunkStore& whole) : _whole(whole) {}
    std::optional<core::Error> put(Chunk) override { return std::nullopt; }
    std::optional<core::Error> finish(const StoredModel&) override { return std::nullopt; }
    [[nodiscard]] const StoredModel& model() const override { return _whole.model(); }
    [[nodiscard]] std::vector<ChunkKey> keys() const override { return _whole.keys(); }
    [[nodiscard]] core::Result<std::optional<Chunk>> get(const ChunkKey& key) const override
    {
        ++reads;
        if (damaged == key)
            return core::failure(core::ErrorCode::badData, "damaged");
        return _whole.get(key);
    }

    std::optional<ChunkKey> damaged;
    mutable std::atomic<std::uint64_t> reads = 0;

private:
    const ChunkStore& _whole;
};

TEST(VoxelRayCaster, givesTheSameOnAnyNumberOfThreadsWithAnyCache)
{
    auto random = tests::random(78);
    const ChunkStore& whole = *hillySphere().store;
    const ChunkCut cut = cutOfLevel(whole, 0);
    std::vector<Ray> rays = raysFromInside(static_cast<std::size_t>(tests::trials(8000)), random);
    for (std::size_t i = 0; i < rays.size(); i += 3)
        rays[i].start *= 3;
    std::vector<std::optional<VoxelHit>> expected;
    const VoxelRayCaster plain = casterOf(whole, cut);
    for (const Ray& ray : rays)
        expected.push_back(*plain.cast(ray));
    for (const std::size_t threads : {1U, 4U}) {
        const auto jobs = core::makeJobs(core::JobsBackend::threads, threads);
        PoorStore all(whole);
        const VoxelRayCaster large = casterOf(all, cut);
        const auto first = large.cast(rays, *jobs);
        ASSERT_TRUE(first);
        EXPECT_TRUE(*first == expected);
        EXPECT_LE(all.reads, cut.size()) << "each chunk is read once";
        EXPECT_EQ(large.statistics().loads, all.reads);
        EXPECT_LT(large.statistics().treeBytes, large.statistics().bytes / 8);

        PoorStore few(whole);
        constexpr std::size_t kLittle = 3'000'000;
        const VoxelRayCaster small = casterOf(few, cut, {.cacheBytes = kLittle});
        const std::span<const Ray> some(rays.data(), rays.size() / 40 + 1);
        const auto second = small.cast(some, *jobs);
        ASSERT_TRUE(second);
        EXPECT_TRUE(std::ranges::equal(*second, std::span(expected).first(some.size())));
        EXPECT_LE(small.statistics().bytes, kLittle);
    }
}

TEST(VoxelRayCaster, saysWhatTheStoreSaysOfAChunkThatCanNotBeRead)
{
    const auto whole = storeOf({{3, 3, 3}, {300, 3, 3}}, 2);
    PoorStore store(*whole);
    store.damaged = ChunkKey{0, 1, 0, 0};
    const VoxelRayCaster caster = casterOf(store, cutOfLevel(store, 0));
    const Ray good{{-5, 3.5, 3.5}, {1, 0, 0}};
    const Ray bad{{500, 3.5, 3.5}, {-1, 0, 0}};
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    for (int i = 0; i < 2; ++i) {
        EXPECT_TRUE(*caster.cast(good));
        ASSERT_FALSE(caster.cast(bad));
        EXPECT_EQ(caster.cast(bad).error().message, "damaged");
    }
    const std::vector<Ray> rays(600, bad);
    EXPECT_EQ(caster.cast(rays, *jobs).error().message, "damaged");
    store.damaged.reset();
    EXPECT_EQ((*caster.cast(bad))->distance, 199);
}

} // namespace
} // namespace isofront::voxels
