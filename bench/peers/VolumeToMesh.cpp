#include "VolumeToMesh.h"

#include <oneapi/tbb/task_arena.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>

namespace {

using Points = std::vector<openvdb::Vec3s>;

/// Samples as OpenVDB likes them: negative inside. Outside of them lies what is just not solid, so
/// that the walls that close the surface there lie outside, too.
openvdb::FloatGrid::Ptr
gridOf(const std::vector<float>& values, const std::array<int, 3>& count, double isovalue)
{
    std::vector<float> turned(values.size());
    std::ranges::transform(values, turned.begin(), [isovalue](float value) {
        return static_cast<float>(isovalue - double(value));
    });
    constexpr float kBackground = std::numeric_limits<float>::min();
    auto grid = openvdb::FloatGrid::create(kBackground);
    grid->setGridClass(openvdb::GRID_LEVEL_SET);
    const openvdb::CoordBBox box(
        openvdb::Coord(0, 0, 0), openvdb::Coord(count[0] - 1, count[1] - 1, count[2] - 1));
    const openvdb::tools::Dense<float, openvdb::tools::LayoutXYZ> dense(box, turned.data());
    openvdb::tools::copyFromDense(dense, *grid, 0.0F);
    return grid;
}

bool isWithin(const openvdb::Vec3s& p, const std::array<int, 3>& count)
{
    for (int axis = 0; axis < 3; ++axis)
        if (!(p[axis] >= 0 && p[axis] <= float(count[static_cast<std::size_t>(axis)] - 1)))
            return false;
    return true;
}

} // namespace

extern "C" void isofrontVolumeToMesh(
    const std::vector<float>& values,
    const std::array<int, 3>& count,
    const std::array<double, 3>& origin,
    double spacing,
    double isovalue,
    double adaptivity,
    isofront::bench::peers::PeerMesh& mesh)
{
    Points points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    oneapi::tbb::task_arena(1).execute([&] {
        const auto grid = gridOf(values, count, isovalue);
        openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0.0, adaptivity);
    });

    for (const openvdb::Vec3s& p : points)
        for (int axis = 0; axis < 3; ++axis)
            mesh.positions.push_back(
                origin[static_cast<std::size_t>(axis)] + spacing * double(p[axis]));
    // the walls lie outside; what is half outside is the surface, up to a step further than it
    // should
    const auto add = [&](std::initializer_list<std::uint32_t> corners) {
        if (std::ranges::any_of(corners, [&](auto v) { return isWithin(points[v], count); }))
            mesh.indices.insert(mesh.indices.end(), corners);
    };
    // its polygons face in
    for (const openvdb::Vec3I& t : triangles)
        add({t[2], t[1], t[0]});
    for (const openvdb::Vec4I& q : quads) {
        const bool first =
            (points[q[2]] - points[q[0]]).lengthSqr() <= (points[q[3]] - points[q[1]]).lengthSqr();
        const unsigned a = first ? 0 : 1;
        add({q[static_cast<int>(a + 2)], q[static_cast<int>(a + 1)], q[static_cast<int>(a)]});
        add({q[static_cast<int>(a)], q[static_cast<int>((a + 3) % 4)], q[static_cast<int>(a + 2)]});
    }
}

extern "C" const char* isofrontOpenVdbVersion()
{
    return OPENVDB_LIBRARY_VERSION_STRING;
}
