#include "TilesetReader.h"
#include "exchange/ExchangeFixture.h"
#include "support/Random.h"

#include <isofront/fields/Shapes.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/surface/MeshExtraction.h>
#include <isofront/tiles/Tileset.h>

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>
#include <string>

namespace isofront::tiles::test {

namespace {

using exchange::test::contentOf;
using exchange::test::ReadMesh;

/// Nothing of it lies on a border of tiles.
constexpr double kRadius = 0.37;
const glm::dvec3 kCentre{0.511, 0.487, 0.503};

class TilesetTest : public exchange::test::ExchangeTest {
protected:
    TilesetTest()
    {
        settings.latticeSize = 4;
        settings.filterStrength = 0;
        options.levels = 3;
        options.tileSteps = 8;
    }

    core::Result<TilesetReport>
    write(const std::string& name, core::JobsBackend backend = core::JobsBackend::automatic)
    {
        const auto jobs = core::makeJobs(backend, 3);
        return writeTileset(field, domain, settings, *jobs, options, path(name));
    }

    std::shared_ptr<const fields::Field> field = fields::sphere(kCentre, kRadius);
    hierarchy::Domain domain;
    extractor::ExtractionSettings settings;
    TilesetOptions options;
};

std::set<std::string> filesIn(const std::filesystem::path& folder)
{
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
        if (entry.is_regular_file())
            names.insert(std::filesystem::relative(entry.path(), folder).string());
    return names;
}

bool contains(const core::Box& outer, const core::Box& inner, double tolerance = 0)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (inner.low[axis] < outer.low[axis] - tolerance ||
            inner.high[axis] > outer.high[axis] + tolerance)
            return false;
    return true;
}

/// The cube of the octree, by the name of its file, in a domain from 0 to 1.
core::Box cubeOf(const ReadTile& tile)
{
    int x = 0;
    int y = 0;
    int z = 0;
    EXPECT_EQ(std::sscanf(tile.uri.c_str(), "%*d/%d-%d-%d.glb", &x, &y, &z), 3);
    const double edge = std::ldexp(1.0, -tile.depth);
    return {edge * glm::dvec3(x, y, z), edge * glm::dvec3(x + 1, y + 1, z + 1)};
}

double areaOf(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    return 0.5 * glm::length(glm::cross(b - a, c - a));
}

/// Tiles that a client may show at once: each leaf, or one of the tiles above it.
void chooseFront(const ReadTile& tile, std::mt19937_64& random, std::vector<const ReadTile*>& front)
{
    if (!tile.children.empty() && (tile.uri.empty() || tests::uniform(random, 0, 1) < 0.7))
        for (const ReadTile& child : tile.children)
            chooseFront(child, random, front);
    else
        front.push_back(&tile);
}

/// A plane just below the middle of the domain that filtering lifts just above it, so that tiles of
/// different levels see it on different sides of a border.
class RisingPlane final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] =
                float(0.499 + 0.1 * (batch.radius.empty() ? 0 : batch.radius[i]) - batch.z[i]);
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return {0.498 - box.high.z, 0.5 + 0.1 * radius.high - box.low.z};
    }
    [[nodiscard]] double differenceStep(double /*radius*/) const override { return 1e-3; }
};

using Triangle = std::array<glm::dvec3, 3>;

/// How far a ray goes until it meets a triangle, from whichever side.
double
firstHit(const std::vector<Triangle>& triangles, const glm::dvec3& eye, const glm::dvec3& direction)
{
    double first = std::numeric_limits<double>::infinity();
    for (const auto& [a, b, c] : triangles) {
        const glm::dvec3 normal = glm::cross(b - a, c - a);
        const double slope = glm::dot(normal, direction);
        if (slope == 0)
            continue;
        const double distance = glm::dot(normal, a - eye) / slope;
        if (distance < 0 || distance >= first)
            continue;
        const glm::dvec3 at = eye + distance * direction;
        const double u = glm::dot(glm::cross(b - a, at - a), normal);
        const double v = glm::dot(glm::cross(c - b, at - b), normal);
        const double w = glm::dot(glm::cross(a - c, at - c), normal);
        if (u >= 0 && v >= 0 && w >= 0)
            first = distance;
    }
    return first;
}

glm::dvec3 randomDirection(std::mt19937_64& random)
{
    for (;;) {
        const glm::dvec3 p{
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1),
            tests::uniform(random, -1, 1)};
        const double length = glm::length(p);
        if (length > 0.1 && length < 1)
            return p / length;
    }
}

} // namespace

TEST_F(TilesetTest, tilesLieInTheirParentsAndGetBetterDownTheTree)
{
    options.levels = 4;
    // askew, mirrored and far from the origin
    domain.worldFromField.linear = {{0, 30, 4}, {20, 1, 0}, {0, 3, 25}};
    domain.worldFromField.translation = {4.1e6, -3e5, 77};
    const auto report = write("tiles");
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_TRUE(report->warnings.empty());
    const ReadTile root = readTileset(path("tiles"));

    std::set<std::string> named{"tileset.json"};
    std::vector<std::size_t> tiles(4);
    std::vector<std::size_t> triangles(4);
    for (const ReadTile* tile : allOf(root)) {
        for (const ReadTile& child : tile->children) {
            EXPECT_TRUE(contains(tile->box, child.box, 1e-9));
            EXPECT_LE(child.error, tile->error);
        }
        EXPECT_EQ(tile->error == 0, tile->children.empty());
        ASSERT_FALSE(tile->uri.empty());
        EXPECT_TRUE(named.insert(tile->uri).second) << tile->uri;
        EXPECT_TRUE(contains(tile->box, tile->contentBox));
        const ReadMesh mesh = readTile(path("tiles"), *tile);
        core::Box tight;
        for (const glm::dvec3& position : mesh.positions)
            tight.include(position);
        // floats are rounded, and the box isn't larger than that asks for
        EXPECT_TRUE(contains(tile->contentBox, tight, 1e-4));
        EXPECT_TRUE(contains(tight, tile->contentBox, 1e-4));
        ++tiles.at(std::size_t(tile->depth));
        triangles.at(std::size_t(tile->depth)) += mesh.indices.size() / 3;
    }
    EXPECT_EQ(filesIn(path("tiles")), named);
    EXPECT_EQ(report->files, named.size());
    ASSERT_EQ(report->levels.size(), 4U);
    for (std::size_t depth = 0; depth < 4; ++depth) {
        EXPECT_EQ(report->levels[depth].tiles, tiles[depth]);
        EXPECT_EQ(report->levels[depth].triangles, triangles[depth]);
    }
    EXPECT_EQ(tiles[0], 1U);
    EXPECT_EQ(tiles[1], 8U);
    EXPECT_GT(tiles[3], tiles[2]);
    // half the step: a quarter of the error, once steps are small beside the ball
    EXPECT_LT(report->levels[2].measuredError, 0.5 * report->levels[1].measuredError);
}

TEST_F(TilesetTest, tilesOfADepthAreTheMeshOfOneLevel)
{
    ASSERT_TRUE(write("tiles"));
    const ReadTile root = readTileset(path("tiles"));
    const auto tiles = allOf(root);
    const auto jobs = core::makeJobs(core::JobsBackend::automatic, 2);
    settings.filterStrength = 0.5; // a ball has nothing to filter
    for (int depth = 0; depth < options.levels; ++depth) {
        surface::MeshExtractionOptions extraction;
        extraction.detail.level = 3 * depth;
        const auto whole = surface::extractMesh(
            std::make_shared<const extractor::CellExtractor>(field, domain, settings),
            *jobs,
            extraction);
        ASSERT_TRUE(whole);
        double wholeArea = 0;
        for (std::size_t i = 0; i < whole->mesh.indices.size(); i += 3)
            wholeArea += areaOf(
                whole->mesh.positions[whole->mesh.indices[i]],
                whole->mesh.positions[whole->mesh.indices[i + 1]],
                whole->mesh.positions[whole->mesh.indices[i + 2]]);

        std::size_t count = 0;
        double area = 0;
        double furthest = 0;
        const double edge = std::ldexp(1.0, -depth);
        for (const ReadTile* tile : tiles) {
            if (tile->depth != depth)
                continue;
            const core::Box cube = cubeOf(*tile);
            const ReadMesh mesh = readTile(path("tiles"), *tile);
            for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
                const glm::dvec3& a = mesh.positions[mesh.indices[i]];
                const glm::dvec3& b = mesh.positions[mesh.indices[i + 1]];
                const glm::dvec3& c = mesh.positions[mesh.indices[i + 2]];
                const glm::dvec3 middle = (a + b + c) / 3.0;
                // outside by its winding, after all the turning
                if (areaOf(a, b, c) > 1e-9) {
                    EXPECT_GT(glm::dot(glm::cross(b - a, c - a), middle - kCentre), 0);
                }
                if (contains(cube, {middle, middle})) {
                    ++count;
                    area += areaOf(a, b, c);
                }
                const glm::dvec3 low = glm::min(glm::min(a, b), c);
                const glm::dvec3 high = glm::max(glm::max(a, b), c);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    furthest = std::max(
                        {furthest, low[axis] - cube.high[axis], cube.low[axis] - high[axis]});
            }
        }
        EXPECT_EQ(count, whole->mesh.indices.size() / 3) << depth;
        EXPECT_NEAR(area, wholeArea, 1e-5 * wholeArea);
        // a rim of one step, no more, and where there is more than one tile no less
        EXPECT_LE(furthest, edge / 8 + 1e-6);
        if (depth > 0) {
            EXPECT_GT(furthest, edge / 10);
        }
    }
}

TEST_F(TilesetTest, noRaySlipsThroughWhatAClientMayShow)
{
    ASSERT_TRUE(write("tiles"));
    const ReadTile root = readTileset(path("tiles"));
    std::map<const ReadTile*, std::vector<Triangle>> meshes;
    for (const ReadTile* tile : allOf(root)) {
        const ReadMesh mesh = readTile(path("tiles"), *tile);
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            meshes[tile].push_back(
                {mesh.positions[mesh.indices[i]],
                 mesh.positions[mesh.indices[i + 1]],
                 mesh.positions[mesh.indices[i + 2]]});
    }
    auto random = tests::random(20);
    int mixed = 0;
    for (int round = 0; round < tests::trials(8); ++round) {
        std::vector<const ReadTile*> front;
        chooseFront(root, random, front);
        std::set<int> depths;
        std::vector<Triangle> shown;
        for (const ReadTile* tile : front) {
            depths.insert(tile->depth);
            const auto& triangles = meshes[tile];
            shown.insert(shown.end(), triangles.begin(), triangles.end());
        }
        mixed += depths.size() > 1 ? 1 : 0;
        for (int ray = 0; ray < 150; ++ray) {
            // towards a place of the ball, half of them where it is seen at a small angle
            const glm::dvec3 direction = randomDirection(random);
            const glm::dvec3 aside = glm::normalize(glm::cross(direction, randomDirection(random)));
            const double off = kRadius * (ray % 2 == 0 ? tests::uniform(random, 0, 0.9)
                                                       : tests::uniform(random, 0.9, 0.95));
            const glm::dvec3 eye = kCentre + off * aside - 3.0 * direction;
            const double truth = 3 - std::sqrt(kRadius * kRadius - off * off);
            // a step of the coarsest level, 1/8, is a third of the radius
            EXPECT_NEAR(firstHit(shown, eye, direction), truth, 0.1)
                << "round " << round << ", ray " << ray;
        }
    }
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(mixed, 4);
    }
}

TEST_F(TilesetTest, noGapOpensWhereASurfaceRunsAlongABorder)
{
    field = std::make_shared<RisingPlane>();
    ASSERT_TRUE(write("tiles"));
    const ReadTile root = readTileset(path("tiles"));
    auto random = tests::random(21);
    int missesWithoutRims = 0;
    for (int round = 0; round < tests::trials(10); ++round) {
        std::vector<const ReadTile*> front;
        chooseFront(root, random, front);
        std::vector<Triangle> shown;
        std::vector<Triangle> withoutRims;
        for (const ReadTile* tile : front) {
            if (tile->uri.empty())
                continue;
            const ReadMesh mesh = readTile(path("tiles"), *tile);
            const core::Box cube = cubeOf(*tile);
            for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
                shown.push_back(
                    {mesh.positions[mesh.indices[i]],
                     mesh.positions[mesh.indices[i + 1]],
                     mesh.positions[mesh.indices[i + 2]]});
                const auto& [a, b, c] = shown.back();
                const glm::dvec3 middle = (a + b + c) / 3.0;
                if (contains(cube, {middle, middle}))
                    withoutRims.push_back(shown.back());
            }
        }
        for (int ray = 0; ray < 100; ++ray) {
            const glm::dvec3 eye{
                tests::uniform(random, 0.01, 0.99), tests::uniform(random, 0.01, 0.99), 2};
            EXPECT_NEAR(firstHit(shown, eye, {0, 0, -1}), 1.5, 0.02);
            missesWithoutRims += std::isinf(firstHit(withoutRims, eye, {0, 0, -1})) ? 1 : 0;
        }
    }
    // a coarse tile and its fine neighbour each leave the plane to the other one
    if (tests::areAllTrialsMade()) {
        EXPECT_GT(missesWithoutRims, 10);
    }
}

TEST_F(TilesetTest, bytesDoNotDependOnThreads)
{
    options.maxError = 0.002;
    ASSERT_TRUE(write("one", core::JobsBackend::inlined));
    ASSERT_TRUE(write("more", core::JobsBackend::threads));
    const auto files = filesIn(path("one"));
    EXPECT_GT(files.size(), 20U);
    EXPECT_EQ(files, filesIn(path("more")));
    for (const std::string& file : files)
        EXPECT_EQ(contentOf(path("one") / file), contentOf(path("more") / file)) << file;
}

TEST_F(TilesetTest, leavesOutWhatAnErrorDoesNotNeed)
{
    options.levels = 4;
    field = fields::torus({0.503, 0.489, 0.511}, 0.3, 0.06);
    ASSERT_TRUE(write("all"));
    const auto all = allOf(readTileset(path("all"))).size();
    options.maxError = 0.002;
    const auto report = write("some");
    ASSERT_TRUE(report);
    const ReadTile root = readTileset(path("some"));
    std::set<int> leafDepths;
    std::set<std::string> named{"tileset.json"};
    for (const ReadTile* tile : allOf(root)) {
        named.insert(tile->uri);
        if (!tile->children.empty())
            continue;
        leafDepths.insert(tile->depth);
        if (tile->depth == 3)
            continue;
        const ReadMesh mesh = readTile(path("some"), *tile);
        for (const glm::dvec3& p : mesh.positions) {
            const glm::dvec3 q = p - glm::dvec3(0.503, 0.489, 0.511);
            const double off = std::abs(std::hypot(std::hypot(q.x, q.y) - 0.3, q.z) - 0.06);
            EXPECT_LE(off, 2 * options.maxError);
        }
    }
    EXPECT_LT(allOf(root).size(), all);
    EXPECT_FALSE(leafDepths.contains(0));
    EXPECT_EQ(filesIn(path("some")), named);

    options.maxError = 1; // anything will do, so the first tile that has all parts does
    ASSERT_TRUE(write("one"));
    EXPECT_LT(allOf(readTileset(path("one"))).size(), allOf(root).size());
}

TEST_F(TilesetTest, keepsBelowACeiling)
{
    options.levels = 4;
    const auto all = write("all");
    ASSERT_TRUE(all);
    options.maxTriangles = all->levels[2].triangles;
    const auto fewer = write("fewer");
    ASSERT_TRUE(fewer);
    ASSERT_EQ(fewer->levels.size(), 3U);
    EXPECT_EQ(fewer->levels[2].triangles, all->levels[2].triangles);
    EXPECT_EQ(fewer->levels[2].error, 0);
    options.maxTriangles = 1;
    const auto none = write("none");
    ASSERT_FALSE(none);
    EXPECT_EQ(none.error().code, core::ErrorCode::resourceLimit);
    EXPECT_NE(none.error().message.find("--max-triangles"), std::string::npos);
}

TEST_F(TilesetTest, leavesNothingBehindThatIsNotWhole)
{
    std::stop_source stop;
    options.stop = stop.get_token();
    for (const std::string part : {"level 2: finding", "level 2: writing", "level 1: writing"}) {
        stop = {};
        options.stop = stop.get_token();
        options.progress = [&](const std::string& what, double) {
            if (what.starts_with(part))
                stop.request_stop();
        };
        const auto report = write("tiles");
        ASSERT_FALSE(report) << part;
        EXPECT_EQ(report.error().code, core::ErrorCode::interrupted);
        EXPECT_TRUE(names().empty()) << part;
    }
}

TEST_F(TilesetTest, refusesFoldersWithSomethingInThem)
{
    std::filesystem::create_directory(path("mine"));
    exchange::test::setContent(path("mine/letter"), "dear");
    exchange::test::setContent(path("file"), "content");
    for (const std::string name : {"mine", "file", "missing/tiles"}) {
        const auto report = write(name);
        ASSERT_FALSE(report) << name;
        EXPECT_EQ(report.error().code, core::ErrorCode::inputOutput) << report.error().message;
    }
    EXPECT_EQ(names(), (std::vector<std::string>{"file", "mine"}));
    EXPECT_EQ(contentOf(path("mine/letter")), "dear");
    std::filesystem::create_directory(path("empty"));
    EXPECT_TRUE(write("empty"));
    EXPECT_TRUE(std::filesystem::exists(path("empty/tileset.json")));
    EXPECT_TRUE(write("slash/"));
    EXPECT_TRUE(std::filesystem::exists(path("slash/tileset.json")));
}

TEST_F(TilesetTest, refusesOptionsOutOfRange)
{
    const auto refused = [&](auto change) {
        const TilesetOptions before = options;
        change(options);
        const auto report = write("tiles");
        options = before;
        return !report && report.error().code == core::ErrorCode::usage && names().empty();
    };
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.levels = 0; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.levels = kMostLevels + 1; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.tileSteps = 4; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.tileSteps = 48; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.tileSteps = -64; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.tileSteps = 2048; }));
    EXPECT_TRUE(refused([](TilesetOptions& o) { o.maxError = -1; }));
    EXPECT_TRUE(
        refused([](TilesetOptions& o) { o.maxError = std::numeric_limits<double>::quiet_NaN(); }));
    EXPECT_TRUE(
        refused([](TilesetOptions& o) { o.maxError = std::numeric_limits<double>::infinity(); }));
}

TEST_F(TilesetTest, anEmptySurfaceIsATilesetWithoutTriangles)
{
    field = fields::sphere({5, 5, 5}, 1);
    const auto report = write("tiles");
    ASSERT_TRUE(report);
    EXPECT_EQ(report->warnings.size(), 1U);
    EXPECT_EQ(report->levels.size(), 1U);
    EXPECT_TRUE(report->bounds.isEmpty());
    const ReadTile root = readTileset(path("tiles"));
    EXPECT_TRUE(root.uri.empty() && root.children.empty());
    EXPECT_TRUE(contains(root.box, domain.fieldBox()));
    EXPECT_EQ(filesIn(path("tiles")), std::set<std::string>{"tileset.json"});
}

} // namespace isofront::tiles::test
