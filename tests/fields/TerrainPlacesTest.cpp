// Overhangs, caves and arches are the point of the terrains: these tests find them.

#include "FieldChecks.h"
#include "TerrainPrinting.h"

#include <isofront/fields/Terrain.h>

#include <array>
#include <queue>

namespace isofront::fields {
namespace {

using namespace test;

/// Solid and empty over a cube of samples.
class Voxels {
public:
    Voxels(const Field& field, const glm::dvec3& low, double step, int size)
        : _size(size), _solid(std::size_t(size) * std::size_t(size) * std::size_t(size))
    {
        Points points;
        for (int z = 0; z < size; ++z)
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    points.x.push_back(low.x + step * x);
                    points.y.push_back(low.y + step * y);
                    points.z.push_back(low.z + step * z);
                    points.radius.push_back(step);
                }
        const std::vector<float> values = valuesOf(field, points.batch());
        for (std::size_t i = 0; i < values.size(); ++i)
            _solid[i] = values[i] >= 0 ? 1 : 0;
    }

    [[nodiscard]] int size() const { return _size; }
    [[nodiscard]] bool inside(int x, int y, int z) const
    {
        return x >= 0 && y >= 0 && z >= 0 && x < _size && y < _size && z < _size;
    }
    /// Outside the cube: sky above, rock below and at the sides, so that only what happens within
    /// the cube counts.
    [[nodiscard]] bool solid(int x, int y, int z) const
    {
        if (inside(x, y, z))
            return _solid[index(x, y, z)] != 0;
        return z < _size;
    }
    [[nodiscard]] std::size_t index(int x, int y, int z) const
    {
        return (std::size_t(z) * std::size_t(_size) + std::size_t(y)) * std::size_t(_size) +
               std::size_t(x);
    }
    [[nodiscard]] bool seesTheSky(int x, int y, int z) const
    {
        for (int above = z; above < _size; ++above)
            if (solid(x, y, above))
                return false;
        return true;
    }

    /// Empty voxels that can be reached through faces from the sky above the cube.
    [[nodiscard]] std::vector<std::uint8_t> reachedFromTheSky() const
    {
        std::vector<std::uint8_t> reached(_solid.size());
        std::queue<std::array<int, 3>> open;
        const auto visit = [&](int x, int y, int z) {
            if (!inside(x, y, z) || solid(x, y, z) || reached[index(x, y, z)] != 0)
                return;
            reached[index(x, y, z)] = 1;
            open.push({x, y, z});
        };
        for (int y = 0; y < _size; ++y)
            for (int x = 0; x < _size; ++x)
                visit(x, y, _size - 1);
        while (!open.empty()) {
            const auto [x, y, z] = open.front();
            open.pop();
            visit(x - 1, y, z);
            visit(x + 1, y, z);
            visit(x, y - 1, z);
            visit(x, y + 1, z);
            visit(x, y, z - 1);
            visit(x, y, z + 1);
        }
        return reached;
    }

private:
    int _size;
    std::vector<std::uint8_t> _solid;
};

/// How many handles the rock has, seen as closed voxels: its first Betti number, from the Euler
/// number of its vertices, edges, faces and voxels, its pieces, and the holes within it. The cube
/// stands in a bowl of rock that is open at the top, so a tunnel that leaves at a side counts as a
/// dead end.
std::ptrdiff_t handlesOf(const Voxels& voxels)
{
    // With the bowl: one layer more on each side, and one of sky on top.
    const int size = voxels.size() + 2;
    const auto solid = [&](int x, int y, int z) {
        if (x < 0 || y < 0 || z < 0 || x >= size || y >= size || z >= size)
            return false;
        return voxels.solid(x - 1, y - 1, z - 1);
    };
    std::ptrdiff_t euler = 0;
    for (int z = 0; z <= size; ++z)
        for (int y = 0; y <= size; ++y)
            for (int x = 0; x <= size; ++x)
                // An element at (x, y, z) with extent in the axes of `kind` touches the voxels on
                // both sides of the axes in which it has none.
                for (unsigned kind = 0; kind < 8; ++kind) {
                    bool present = false;
                    for (unsigned side = 0; side < 8 && !present; ++side) {
                        if ((side & kind) != 0)
                            continue;
                        present = solid(
                            x - int(side & 1U),
                            y - int((side >> 1U) & 1U),
                            z - int((side >> 2U) & 1U));
                    }
                    if (present)
                        euler += std::popcount(kind) % 2 == 0 ? 1 : -1;
                }

    // Pieces of rock (through faces, edges and corners) and of air (through faces).
    const std::size_t span = std::size_t(size) + 2;
    std::vector<std::uint8_t> seen(span * span * span);
    const auto flood = [&](int x0, int y0, int z0, bool rock) {
        std::queue<std::array<int, 3>> open;
        const auto visit = [&](int x, int y, int z) {
            if (x < -1 || y < -1 || z < -1 || x > size || y > size || z > size ||
                solid(x, y, z) != rock)
                return;
            std::uint8_t& mark =
                seen[(std::size_t(z + 1) * span + std::size_t(y + 1)) * span + std::size_t(x + 1)];
            if (mark != 0)
                return;
            mark = 1;
            open.push({x, y, z});
        };
        visit(x0, y0, z0);
        if (open.empty())
            return false;
        while (!open.empty()) {
            const auto [x, y, z] = open.front();
            open.pop();
            for (int dz = -1; dz <= 1; ++dz)
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx)
                        if (rock || std::abs(dx) + std::abs(dy) + std::abs(dz) == 1)
                            visit(x + dx, y + dy, z + dz);
        }
        return true;
    };
    std::ptrdiff_t pieces = 0;
    std::ptrdiff_t airs = 0;
    for (int z = -1; z <= size; ++z)
        for (int y = -1; y <= size; ++y)
            for (int x = -1; x <= size; ++x) {
                if (solid(x, y, z))
                    pieces += flood(x, y, z, true) ? 1 : 0;
                else
                    airs += flood(x, y, z, false) ? 1 : 0;
            }
    // euler = pieces - handles + holes, and one of the airs is the outside.
    return pieces + (airs - 1) - euler;
}

/// A field from any function, for testing the counts themselves.
template <typename Function>
class FunctionField final : public Field {
public:
    explicit FunctionField(Function function) : _function(function) {}
    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(_function(batch.x[i], batch.y[i], batch.z[i]));
    }
    core::Interval bounds(const core::Box&, core::Interval) const override { return {}; }
    double differenceStep(double) const override { return 0.1; }

private:
    Function _function;
};

template <typename Function>
std::ptrdiff_t handlesOf(Function function)
{
    return handlesOf(Voxels(FunctionField(function), glm::dvec3(0), 1, 20));
}

TEST(Handles, areCountedInRockWithAKnownNumber)
{
    const auto ground = [](double, double, double z) { return 10 - z; };
    const auto dented = [](double x, double y, double z) {
        return std::max(std::abs(x - 10), std::abs(y - 10)) < 3 && z > 4 ? -1.0 : 10 - z;
    };
    // A tunnel through a ridge along y.
    const auto arch = [](double x, double y, double z) {
        const double ridge = (std::abs(x - 10) < 4 ? 16 : 4) - z;
        return std::abs(y - 10) < 2 && z > 6 && z < 10 ? -1.0 : ridge;
    };
    // The same tunnel closed at one end.
    const auto cave = [](double x, double y, double z) {
        const double ridge = (std::abs(x - 10) < 4 ? 16 : 4) - z;
        return std::abs(y - 10) < 2 && z > 6 && z < 10 && x < 12 ? -1.0 : ridge;
    };
    const auto hollow = [](double x, double y, double z) {
        return std::max({std::abs(x - 10), std::abs(y - 10), std::abs(z - 5)}) < 2 ? -1.0 : 10 - z;
    };
    EXPECT_EQ(handlesOf(ground), 0);
    EXPECT_EQ(handlesOf(dented), 0);
    EXPECT_EQ(handlesOf(arch), 1);
    EXPECT_EQ(handlesOf(cave), 0);
    EXPECT_EQ(handlesOf(hollow), 0);
}

class TerrainPlaces : public testing::TestWithParam<TerrainPreset> {
protected:
    [[nodiscard]] static std::shared_ptr<const Field> make()
    {
        return terrain({.preset = GetParam().name, .seed = 1});
    }

    /// Cubes of 40 voxels of 8 m about the surface, at fixed places.
    template <typename Body>
    static void forEachPlace(const Field& field, int count, const Body& body)
    {
        constexpr int kSize = 40;
        constexpr double kStep = 8;
        Random random(61);
        for (int i = 0; i < count; ++i) {
            const double x = random(-7000, 7000);
            const double y = random(-7000, 7000);
            const double height = surfaceHeight(field, GetParam().box, x, y, 32);
            if (height == GetParam().box.low.z)
                continue;
            const double half = 0.5 * kStep * kSize;
            const glm::dvec3 low(x - half, y - half, height - 1.2 * half);
            if (!body(Voxels(field, low, kStep, kSize)))
                return;
        }
    }
};

INSTANTIATE_TEST_SUITE_P(
    Presets,
    TerrainPlaces,
    testing::ValuesIn(terrainPresets()),
    [](const testing::TestParamInfo<TerrainPreset>& instance) { return instance.param.name; });

TEST_P(TerrainPlaces, haveOverhangs)
{
    const std::shared_ptr<const Field> field = make();
    Random random(62);
    std::size_t overhangs = 0;
    constexpr std::size_t kColumns = 300;
    for (std::size_t i = 0; i < kColumns; ++i) {
        Points column;
        const double x = random(-8000, 8000);
        const double y = random(-8000, 8000);
        for (double z = -1500; z < 3500; z += 4) {
            column.x.push_back(x);
            column.y.push_back(y);
            column.z.push_back(z);
        }
        const std::vector<float> values = valuesOf(*field, column.batch());
        int changes = 0;
        for (std::size_t k = 1; k < values.size(); ++k)
            changes += (values[k] >= 0) != (values[k - 1] >= 0) ? 1 : 0;
        overhangs += changes >= 3 ? 1U : 0U;
    }
    RecordProperty("overhangPercent", static_cast<int>(100 * overhangs / kColumns));
    EXPECT_GT(overhangs, kColumns / 25);
}

TEST_P(TerrainPlaces, haveCavesThatOpenSideways)
{
    // A voxel of a cave has forty metres of rock overhead, and the sky can be reached from it. That
    // way has to lead sideways, since straight up there is rock.
    const std::shared_ptr<const Field> field = make();
    std::size_t caves = 0;
    forEachPlace(*field, 40, [&](const Voxels& voxels) {
        const std::vector<std::uint8_t> reached = voxels.reachedFromTheSky();
        std::size_t voxelsInside = 0;
        for (int z = 0; z + 8 < voxels.size(); ++z)
            for (int y = 0; y < voxels.size(); ++y)
                for (int x = 0; x < voxels.size(); ++x) {
                    if (reached[voxels.index(x, y, z)] == 0)
                        continue;
                    int rock = 0;
                    for (int above = z + 1; above < voxels.size(); ++above)
                        rock += voxels.solid(x, y, above) ? 1 : 0;
                    voxelsInside += rock >= 5 ? 1U : 0U;
                }
        // Room to fly: as much as a hall of 40 m each way.
        caves += voxelsInside >= 125 ? 1U : 0U;
        return caves < 3;
    });
    EXPECT_GE(caves, 3U);
}

TEST_P(TerrainPlaces, haveArches)
{
    const std::shared_ptr<const Field> field = make();
    std::size_t places = 0;
    forEachPlace(*field, 60, [&](const Voxels& voxels) {
        places += handlesOf(voxels) > 0 ? 1U : 0U;
        return places < 2;
    });
    EXPECT_GE(places, 2U);
}

TEST_P(TerrainPlaces, haveAKilometreOfReliefAndAStartInTheOpen)
{
    const std::shared_ptr<const Field> field = make();
    Random random(63);
    double low = 1e9;
    double high = -1e9;
    for (int i = 0; i < 1000; ++i) {
        const double height =
            surfaceHeight(*field, GetParam().box, random(-8000, 8000), random(-8000, 8000), 32);
        if (height == GetParam().box.low.z)
            continue;
        low = std::min(low, height);
        high = std::max(high, height);
    }
    EXPECT_GT(high - low, 1000);
    EXPECT_LT(high, GetParam().box.high.z - 1000);
    EXPECT_GT(low, GetParam().box.low.z + 1000);
}

} // namespace
} // namespace isofront::fields
