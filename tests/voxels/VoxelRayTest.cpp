#include "Models.h"
#include "MovedRay.h"
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
