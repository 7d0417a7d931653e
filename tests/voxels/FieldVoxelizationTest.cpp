#include "FieldRasteriser.h"
#include "VoxelSets.h"
#include "support/FunctionField.h"
#include "support/Random.h"

#include <isofront/fields/Combine.h>
#include <isofront/fields/Shapes.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <set>

namespace isofront::voxels {
namespace {

using tests::Cube;
using tests::Flood;
using tests::FunctionField;
using tests::voxelsOf;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Made {
    FieldVoxelizationReport report;
    tests::KeptChunks kept;
};

std::unique_ptr<Made>
make(const fields::Field& field, const FieldVoxelizationSettings& settings, std::size_t threads = 2)
{
    auto made = std::make_unique<Made>();
    const auto jobs = core::makeJobs(core::JobsBackend::threads, threads);
    const auto report = voxelizeField(field, settings, made->kept, *jobs);
    EXPECT_TRUE(report) << report.error().message;
    if (report)
        made->report = *report;
    return made;
}

std::set<Cube> placesOf(const tests::KeptChunks& kept)
{
    std::set<Cube> places;
    for (const auto& [cube, voxel] : voxelsOf(kept, 0))
        places.insert(cube);
    return places;
}

/// A box of whole voxels of edge 1 about the origin.
core::Box boxOf(double x, double y, double z)
{
    const glm::dvec3 half(0.5 * x, 0.5 * y, 0.5 * z);
    return {-half, half};
}

/// A field on the lattice, looked at everywhere.
class Brute {
public:
    Brute(const fields::Field& field, const FieldVoxelizationSettings& settings)
        : _field(field), _settings(settings)
    {
        const glm::dvec3 size = settings.box.size() / settings.edge;
        counts = {
            static_cast<int>(std::round(size.x)),
            static_cast<int>(std::round(size.y)),
            static_cast<int>(std::round(size.z))};
    }
    /// @param half  in halves of a voxel
    [[nodiscard]] bool inside(const Cube& half) const
    {
        const auto known = _known.find(half);
        if (known != _known.end())
            return known->second;
        const glm::dvec3 p =
            _settings.box.low + 0.5 * _settings.edge * glm::dvec3(half[0], half[1], half[2]);
        const std::array<double, 1> radius{2 * _settings.filterStrength * _settings.edge};
        float value = 0;
        _field.sample(
            {std::span(&p.x, 1), std::span(&p.y, 1), std::span(&p.z, 1), radius},
            std::span(&value, 1));
        return _known[half] = static_cast<double>(value) >= _settings.isovalue;
    }
    [[nodiscard]] std::set<Cube> voxels(bool conservative) const
    {
        std::set<Cube> found;
        Cube c{};
        for (c[2] = 0; c[2] < counts[2]; ++c[2])
            for (c[1] = 0; c[1] < counts[1]; ++c[1])
                for (c[0] = 0; c[0] < counts[0]; ++c[0]) {
                    const Cube middle{2 * c[0] + 1, 2 * c[1] + 1, 2 * c[2] + 1};
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        if (c[axis] + 1 == counts[axis])
                            continue;
                        Cube face = middle;
                        ++face[axis];
                        Cube next = middle;
                        next[axis] += 2;
                        if (inside(middle) == inside(next))
                            continue;
                        Cube which = c;
                        which[axis] += inside(face) == inside(middle) ? 1 : 0;
                        found.insert(which);
                    }
                    for (int corner = 0; corner < 8 && conservative; ++corner)
                        if (inside(
                                {middle[0] - 1 + 2 * (corner & 1),
                                 middle[1] - 1 + (corner & 2),
                                 middle[2] - 1 + (corner & 4) / 2}) != inside(middle))
                            found.insert(c);
                }
        return found;
    }

    Cube counts{};

private:
    const fields::Field& _field;
    const FieldVoxelizationSettings& _settings;
    mutable std::map<Cube, bool> _known;
};

struct Shape {
    const char* name;
    std::shared_ptr<const fields::Field> field;
};

class FieldShapes : public testing::TestWithParam<int> {
protected:
    static Shape shape()
    {
        switch (GetParam()) {
        case 0:
            return {"sphere", fields::sphere({0.3, 0.1, -0.2}, 9.3)};
        case 1:
            return {"torus", fields::torus({0.3, 0.1, -0.2}, 7.1, 2.6)};
        case 2:
            return {"gyroid", fields::gyroid(9.7)};
        default:
            return {"noise", std::make_shared<FunctionField>([](const glm::dvec3& p, double) {
                        return tests::hashed(p, 0, 3) - 0.7;
                    })};
        }
    }
};

TEST_P(FieldShapes, areTheVoxelsThatLookingEverywhereFinds)
{
    for (const bool conservative : {false, true}) {
        FieldVoxelizationSettings settings{.box = boxOf(30, 22, 24), .filterStrength = 0};
        if (conservative)
            settings.separability = Separability::conservative;
        const Shape shape = FieldShapes::shape();
        const auto made = make(*shape.field, settings);
        const std::set<Cube> expected = Brute(*shape.field, settings).voxels(conservative);
        EXPECT_EQ(placesOf(made->kept), expected) << shape.name << conservative;
        EXPECT_EQ(made->report.voxels, expected.size());
        EXPECT_EQ(made->report.chunks, 1U);
    }
}

TEST_P(FieldShapes, showTheFacesThatAFloodReachesAroundTheSolid)
{
    const FieldVoxelizationSettings settings{.box = boxOf(30, 22, 24), .filterStrength = 0};
    const Shape shape = FieldShapes::shape();
    const auto made = make(*shape.field, settings);
    const auto voxels = voxelsOf(made->kept, 0);
    // what is solid keeps the flood out even where the surface ends at the border
    const Brute brute(*shape.field, settings);
    std::map<Cube, Voxel> full = voxels;
    Cube c{};
    for (c[2] = 0; c[2] < brute.counts[2]; ++c[2])
        for (c[1] = 0; c[1] < brute.counts[1]; ++c[1])
            for (c[0] = 0; c[0] < brute.counts[0]; ++c[0])
                if (brute.inside({2 * c[0] + 1, 2 * c[1] + 1, 2 * c[2] + 1}))
                    full[c] = {};
    Flood flood(full, 30, false);
    for (const auto& [cube, voxel] : voxels)
        for (std::size_t face = 0; face < kFaces; ++face) {
            const auto& step = kFaceSteps[face];
            EXPECT_EQ(
                (voxel.faces() >> face & 1) != 0,
                flood.reaches({cube[0] + step[0], cube[1] + step[1], cube[2] + step[2]}));
        }
}

std::string nameOfShape(const testing::TestParamInfo<int>& shape)
{
    constexpr std::array kNames{"sphere", "torus", "gyroid", "noise"};
    return kNames[static_cast<std::size_t>(shape.param)];
}

INSTANTIATE_TEST_SUITE_P(Shapes, FieldShapes, testing::Range(0, 4), nameOfShape);

TEST(FieldVoxelization, isTheSameAcrossTheBordersOfChunks)
{
    // a bar over two chunks, once as a whole and once looked at everywhere
    const auto gyroid = fields::gyroid(13.1);
    const FieldVoxelizationSettings settings{.box = boxOf(300, 14, 12), .filterStrength = 0};
    const auto made = make(*gyroid, settings);
    EXPECT_EQ(made->report.lattice.levels, 2U);
    EXPECT_EQ(made->report.chunks, 3U);
    EXPECT_EQ(placesOf(made->kept), Brute(*gyroid, settings).voxels(false));
}

TEST(FieldVoxelization, gives6SeparatingAndConservativeVoxelsInTheNumbersThatAreKnown)
{
    // a plane is met by max |n| times its area, and touched by |x| + |y| + |z| of its normal
    const double radius = 45;
    const auto ball = fields::sphere({0.1, 0.2, 0.3}, radius);
    double six = 0;
    double all = 0;
    constexpr int kSteps = 200;
    for (int i = 0; i < kSteps; ++i)
        for (int j = 0; j < kSteps; ++j) {
            const double z = 2 * (i + 0.5) / kSteps - 1;
            const double phi = 2 * std::numbers::pi * (j + 0.5) / kSteps;
            const double r = std::sqrt(1 - z * z);
            const double x = std::abs(r * std::cos(phi));
            const double y = std::abs(r * std::sin(phi));
            six += std::max({x, y, std::abs(z)}) / (kSteps * kSteps);
            all += (x + y + std::abs(z)) / (kSteps * kSteps);
        }
    const double area = 4 * std::numbers::pi * radius * radius;
    FieldVoxelizationSettings settings{.box = boxOf(100, 100, 100)};
    const auto separating = make(*ball, settings);
    EXPECT_NEAR(static_cast<double>(separating->report.voxels) / (six * area), 1, 0.005);
    settings.separability = Separability::conservative;
    const auto conservative = make(*ball, settings);
    EXPECT_NEAR(static_cast<double>(conservative->report.voxels) / (all * area), 1, 0.005);
    const std::set<Cube> more = placesOf(conservative->kept);
    for (const Cube& cube : placesOf(separating->kept))
        EXPECT_TRUE(more.contains(cube));

    Flood flood(voxelsOf(separating->kept, 0), 100, false);
    EXPECT_FALSE(flood.reaches({50, 50, 50}));
    Flood diagonal(voxelsOf(conservative->kept, 0), 100, true);
    EXPECT_FALSE(diagonal.reaches({50, 50, 50}));
}

TEST(FieldVoxelization, weighsEachVoxelByItsArea)
{
    const double radius = 40;
    const auto ball = fields::sphere({0.1, 0.2, 0.3}, radius);
    const FieldVoxelizationSettings settings{.box = boxOf(100, 100, 100)};
    const FieldGrid grid(*ball, settings, latticeOf(settings));
    FieldRasteriser rasteriser;
    VoxelList list;
    FieldRasteriser::Counts counts;
    rasteriser.run(grid, {0, 0, 0}, {{0, 0, 0}, {100, 100, 100}}, {}, list, counts);
    double area = 0;
    for (const WeightedVoxel& voxel : list.voxels)
        area += static_cast<double>(voxel.area);
    EXPECT_NEAR(area / (4 * std::numbers::pi * radius * radius), 1, 0.002);
    EXPECT_TRUE(list.faces.empty());
    // the work is that of the surface
    EXPECT_LT(counts.samples, 100 * 100 * 100 * 6 / 10);
    EXPECT_EQ(counts.sanitised, 0U);
}

TEST(FieldVoxelization, givesTheSameChunksInTheSameOrderOnAnyNumberOfThreads)
{
    const core::Box box = boxOf(260, 16, 258);
    const auto field = fields::colouredByPlace(fields::gyroid(21), box);
    const FieldVoxelizationSettings settings{.box = box, .closed = true};
    const auto one = make(*field, settings, 1);
    const auto four = make(*field, settings, 4);
    EXPECT_EQ(one->kept.order, four->kept.order);
    EXPECT_EQ(one->kept.chunks, four->kept.chunks);
    EXPECT_EQ(one->report.samples, four->report.samples);
    EXPECT_GT(one->kept.chunks.size(), 4U);
}

TEST(FieldVoxelization, knowsNormalsAndColours)
{
    const core::Box box = boxOf(40, 40, 40);
    const glm::dvec3 centre(0.4, -0.3, 0.2);
    const auto field = fields::colouredByPlace(fields::sphere(centre, 15), box);
    const auto made = make(*field, {.box = box});
    ASSERT_EQ(made->kept.chunks.size(), 1U);
    const Chunk& chunk = made->kept.chunks.begin()->second;
    ASSERT_EQ(chunk.colours.size(), chunk.voxels.size());
    for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
        const Voxel& voxel = chunk.voxels[i];
        const glm::dvec3 middle =
            box.low + glm::dvec3(voxel.x() + 0.5, voxel.y() + 0.5, voxel.z() + 0.5);
        EXPECT_GT(glm::dot(glm::normalize(middle - centre), unpackNormal(voxel.normal)), 0.998);
        const std::uint32_t place[3] = {voxel.x(), voxel.y(), voxel.z()};
        for (unsigned axis = 0; axis < 3; ++axis)
            EXPECT_NEAR(
                chunk.colours[i] >> 8 * axis & 0xffU,
                (place[axis] + 0.5) * 255 / 40,
                0.6 * 255 / 40);
        EXPECT_EQ(chunk.colours[i] >> 24U, 255U);
    }
}

TEST(FieldVoxelization, endsOpenOrClosedAtTheBorder)
{
    // solid below a plane
    const auto ground = fields::plane({0, 0, 0.2}, {0, 0, 1});
    FieldVoxelizationSettings settings{.box = boxOf(30, 20, 10)};
    const auto open = make(*ground, settings);
    std::set<Cube> layer;
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 30; ++x)
            layer.insert({x, y, 5});
    EXPECT_EQ(placesOf(open->kept), layer);
    for (const auto& [cube, voxel] : voxelsOf(open->kept, 0)) {
        EXPECT_TRUE((voxel.faces() & faceBit(Face::highZ)) != 0);
        EXPECT_FALSE((voxel.faces() & faceBit(Face::lowZ)) != 0) << "seen from inside";
    }

    settings.closed = true;
    const auto closed = make(*ground, settings);
    std::set<Cube> shell = layer;
    for (int z = 0; z < 5; ++z)
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 30; ++x)
                if (z == 0 || x == 0 || x == 29 || y == 0 || y == 19)
                    shell.insert({x, y, z});
    EXPECT_EQ(placesOf(closed->kept), shell);
    for (const auto& [cube, voxel] : voxelsOf(closed->kept, 0)) {
        if (cube[2] > 0 && cube[2] < 5 && cube[0] == 0 && cube[1] > 0 && cube[1] < 19) {
            EXPECT_NEAR(glm::distance(unpackNormal(voxel.normal), {-1, 0, 0}), 0, 0.01);
            EXPECT_EQ(voxel.faces(), faceBit(Face::lowX));
        }
    }
}

TEST(FieldVoxelization, neverShowsWhatIsAllInsideOrOutside)
{
    for (const double value : {1.0, -1.0, kInfinity, -kInfinity, std::nan("")}) {
        const FunctionField field([&](const glm::dvec3&, double) { return value; });
        FieldVoxelizationSettings settings{.box = boxOf(20, 10, 5)};
        const auto open = make(field, settings);
        EXPECT_TRUE(open->kept.chunks.empty()) << value;
        EXPECT_EQ(open->report.voxels, 0U);
        EXPECT_EQ(open->report.sanitisedSamples > 0, !std::isfinite(value));
        settings.closed = true;
        // a box's shell, or nothing
        EXPECT_EQ(make(field, settings)->report.voxels, value > 0 ? 1000U - 18U * 8U * 3U : 0U);
    }
}

TEST(FieldVoxelization, takesNothingButNumbersForSolid)
{
    const FunctionField field(
        [](const glm::dvec3& p, double) { return p.x < 0 ? 1 : std::nan(""); });
    const auto made = make(field, {.box = boxOf(10, 6, 6)});
    const auto voxels = voxelsOf(made->kept, 0);
    EXPECT_EQ(voxels.size(), 36U);
    for (const auto& [cube, voxel] : voxels) {
        EXPECT_NEAR(cube[0], 4.5, 0.6);
        EXPECT_NEAR(glm::distance(unpackNormal(voxel.normal), {1, 0, 0}), 0, 0.01);
    }
    EXPECT_GT(made->report.sanitisedSamples, 0U);
}

TEST(FieldVoxelization, samplesAtTheRadiusOfItsVoxels)
{
    for (const double strength : {0.0, 0.5, 1.5}) {
        std::atomic<bool> other = false;
        const FunctionField field([&](const glm::dvec3& p, double radius) {
            if (std::abs(radius - 2 * strength * 0.25) > 1e-12)
                other = true;
            return tests::sphere(p, glm::dvec3(0), 2);
        });
        make(field, {.box = boxOf(6, 6, 6), .edge = 0.25, .filterStrength = strength});
        EXPECT_FALSE(other) << strength;
    }
}

TEST(FieldVoxelization, holdsInCoarserLevelsWhatSamplingAtTheirRadiusFinds)
{
    const auto gyroid = fields::gyroid(23.7);
    FieldVoxelizationSettings settings{.box = boxOf(300, 48, 48)};
    const auto fine = make(*gyroid, settings);
    settings.edge = 2;
    const auto coarse = make(*gyroid, settings);
    const auto reduced = voxelsOf(fine->kept, 1);
    const std::set<Cube> sampled = placesOf(coarse->kept);
    ASSERT_GT(sampled.size(), 5000U);
    std::size_t missing = 0;
    for (const Cube& c : sampled) {
        bool isNear = false;
        for (int i = 0; i < 27 && !isNear; ++i)
            isNear = reduced.contains({c[0] + i % 3 - 1, c[1] + i / 3 % 3 - 1, c[2] + i / 9 - 1});
        EXPECT_TRUE(isNear);
        missing += reduced.contains(c) ? 0U : 1U;
    }
    EXPECT_LT(static_cast<double>(missing), 0.01 * static_cast<double>(sampled.size()));
}

/// A ball in the world, seen from a space that is turned, stretched and moved.
struct Turned {
    explicit Turned(std::optional<core::Box> data = std::nullopt)
        : field(
              [this](const glm::dvec3& p, double) {
                  return tests::sphere(map.point(p), {1, 2, 3}, 11);
              },
              1e-3,
              std::move(data))
    {
        const glm::dmat4 turn = glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(1, 2, 3));
        map.linear = glm::dmat3(turn) * glm::dmat3(0.7, 0, 0, 0, -0.5, 0, 0, 0, 2);
        map.translation = {1, 2, 3};
    }
    core::Affine map;
    FunctionField field;
};

TEST(FieldVoxelization, worksInTheWorldHoweverTheFieldLiesInIt)
{
    const Turned turned;
    FieldVoxelizationSettings settings{.box = boxOf(32, 32, 32)};
    const FunctionField plain([](const glm::dvec3& p, double) {
        return tests::sphere(p, {1, 2, 3}, 11);
    });
    const auto expected = make(plain, settings);
    settings.worldFromField = turned.map;
    const auto made = make(turned.field, settings);
    EXPECT_EQ(placesOf(made->kept), placesOf(expected->kept));
    for (const auto& [cube, voxel] : voxelsOf(made->kept, 0)) {
        const glm::dvec3 middle =
            settings.box.low + glm::dvec3(cube[0] + 0.5, cube[1] + 0.5, cube[2] + 0.5);
        EXPECT_GT(
            glm::dot(glm::normalize(middle - glm::dvec3(1, 2, 3)), unpackNormal(voxel.normal)),
            0.995);
    }
}

TEST(FieldVoxelization, closesWhatIsCutByATurnedBorder)
{
    // the data are a slab through the ball's middle
    const Turned turned(core::Box{glm::dvec3(-60, -60, -1.5), glm::dvec3(60, 60, 1.5)});
    FieldVoxelizationSettings settings{
        .box = boxOf(40, 40, 40), .worldFromField = turned.map, .filterStrength = 0};
    settings.closed = true;
    const auto made = make(turned.field, settings);
    const auto voxels = voxelsOf(made->kept, 0);
    Flood flood(voxels, 40, false);
    EXPECT_FALSE(flood.reaches({21, 22, 23}));
    const glm::dvec3 along = glm::normalize(turned.map.linear[2]);
    std::size_t caps = 0;
    for (const auto& [cube, voxel] : voxels) {
        const glm::dvec3 middle =
            settings.box.low + glm::dvec3(cube[0] + 0.5, cube[1] + 0.5, cube[2] + 0.5);
        const double height = glm::dot(middle - glm::dvec3(1, 2, 3), along);
        EXPECT_LT(std::abs(height), 3 + 0.87);
        if (glm::distance(middle, {1, 2, 3}) > 9)
            continue;
        ++caps;
        EXPECT_GT(std::abs(height), 3 - 1.74);
        EXPECT_GT(glm::dot(unpackNormal(voxel.normal), along) * (height > 0 ? 1 : -1), 0.999);
    }
    EXPECT_GT(caps, 400U);
    // open, only the ball's own surface is left
    settings.closed = false;
    for (const auto& [cube, voxel] : voxelsOf(make(turned.field, settings)->kept, 0)) {
        const glm::dvec3 middle =
            settings.box.low + glm::dvec3(cube[0] + 0.5, cube[1] + 0.5, cube[2] + 0.5);
        EXPECT_NEAR(glm::distance(middle, {1, 2, 3}), 11, 0.87);
    }
}

TEST(FieldVoxelization, keepsBothSidesOfWhatIsThinnerThanAVoxel)
{
    // a sheet in the middle of a layer of voxels, red above and green below
    class Sheet final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            for (std::size_t i = 0; i < values.size(); ++i)
                values[i] = static_cast<float>(0.3 - std::abs(batch.z[i] - 0.5));
        }
        [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
        {
            return {};
        }
        [[nodiscard]] double differenceStep(double) const override { return 0.01; }
        [[nodiscard]] bool hasAttributes() const override { return true; }
        void
        attributes(const fields::SampleBatch& batch, std::span<std::uint32_t> words) const override
        {
            for (std::size_t i = 0; i < words.size(); ++i)
                words[i] = batch.z[i] > 0.5 ? 0x0000ffU : 0x00ff00U;
        }
    };
    const Sheet sheet;
    const auto made = make(sheet, {.box = boxOf(300, 12, 12)});
    ASSERT_EQ(made->report.lattice.levels, 2U);
    for (const auto& [key, chunk] : made->kept.chunks) {
        ASSERT_EQ(chunk.faceSets.size(), chunk.voxels.size()) << "level " << key.level;
        EXPECT_EQ(chunk.faceAttributes.size(), 2U) << "shared";
        for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
            const FaceAttributes above = attributesOf(chunk, i, Face::highZ);
            const FaceAttributes below = attributesOf(chunk, i, Face::lowZ);
            EXPECT_EQ(unpackNormal(above.normal), glm::dvec3(0, 0, 1));
            EXPECT_EQ(unpackNormal(below.normal), glm::dvec3(0, 0, -1));
            EXPECT_EQ(above.colour, 0xff0000ffU);
            EXPECT_EQ(below.colour, 0xff00ff00U);
        }
    }
}

TEST(FieldVoxelization, tellsWhatMakesNoSense)
{
    const auto ball = fields::sphere(glm::dvec3(0), 3);
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    tests::KeptChunks kept;
    const FieldVoxelizationSettings good{.box = boxOf(8, 8, 8)};
    const auto codeOf = [&](const auto& change) {
        FieldVoxelizationSettings settings = good;
        change(settings);
        const auto result = voxelizeField(*ball, settings, kept, *jobs);
        return result ? core::ErrorCode::interrupted : result.error().code;
    };
    using S = FieldVoxelizationSettings;
    const double none = std::nan("");
    const auto usage = core::ErrorCode::usage;
    EXPECT_EQ(codeOf([](S& s) { s.box = {}; }), usage);
    EXPECT_EQ(codeOf([&](S& s) { s.box.high.y = kInfinity; }), usage);
    EXPECT_EQ(codeOf([&](S& s) { s.edge = none; }), usage);
    EXPECT_EQ(codeOf([](S& s) { s.edge = 0; }), usage);
    EXPECT_EQ(codeOf([](S& s) { s.edge = 1e-9; }), usage);
    EXPECT_EQ(codeOf([](S& s) { s.box = {{1e30, 0, 0}, {1e30, 8, 8}}; }), usage);
    EXPECT_EQ(codeOf([&](S& s) { s.isovalue = none; }), usage);
    EXPECT_EQ(codeOf([](S& s) { s.filterStrength = -1; }), usage);
    EXPECT_EQ(codeOf([](S& s) { s.worldFromField.linear = glm::dmat3(0); }), usage);
    EXPECT_TRUE(kept.chunks.empty());
    EXPECT_EQ(codeOf([](S& s) { s.scratchFolder = "/nowhere"; }), core::ErrorCode::inputOutput);
    const std::atomic<bool> cancelled = true;
    EXPECT_EQ(
        voxelizeField(*ball, good, kept, *jobs, &cancelled).error().code,
        core::ErrorCode::interrupted);
    double last = -1;
    ASSERT_TRUE(voxelizeField(*ball, good, kept, *jobs, nullptr, [&](double share) {
        EXPECT_GE(share, last);
        last = share;
    }));
    EXPECT_EQ(last, 1);
    EXPECT_EQ(kept.chunks.size(), 1U);
}

TEST(FieldVoxelization, isInterruptedWhereverItIsToldToEnd)
{
    // told by its own samples: a chunk of which only a part was made is no model, even an empty
    // part
    const FieldVoxelizationSettings settings{.box = boxOf(140, 140, 140)};
    for (const std::size_t last : {1U, 100'000U, 300'000U}) {
        std::atomic<bool> cancelled = false;
        std::size_t samples = 0;
        const FunctionField ball([&](const glm::dvec3& p, double) {
            cancelled = cancelled || ++samples >= last;
            return tests::sphere(p, glm::dvec3(30), 9.3);
        });
        const auto jobs = core::makeJobs(core::JobsBackend::inlined);
        tests::KeptChunks kept;
        const auto result = voxelizeField(ball, settings, kept, *jobs, &cancelled);
        ASSERT_GE(samples, last);
        ASSERT_FALSE(result) << last;
        EXPECT_EQ(result.error().code, core::ErrorCode::interrupted);
        EXPECT_TRUE(kept.chunks.empty());
    }
}

} // namespace
} // namespace isofront::voxels
