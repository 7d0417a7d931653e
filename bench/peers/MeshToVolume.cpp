#include "MeshToVolume.h"

#include <oneapi/tbb/task_arena.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>

namespace {

/// A mesh as OpenVDB asks for it.
struct Triangles {
    const std::vector<std::array<double, 3>>& positions;
    const std::vector<std::array<std::uint32_t, 3>>& corners;

    [[nodiscard]] std::size_t polygonCount() const { return corners.size(); }
    [[nodiscard]] std::size_t pointCount() const { return positions.size(); }
    [[nodiscard]] std::size_t vertexCount(std::size_t) const { return 3; }
    void getIndexSpacePoint(std::size_t polygon, std::size_t corner, openvdb::Vec3d& point) const
    {
        const std::array<double, 3>& p = positions[corners[polygon][corner]];
        point = {p[0], p[1], p[2]};
    }
};

} // namespace

extern "C" isofront::bench::peers::PeerVoxels isofrontMeshToVolume(
    const std::vector<std::array<double, 3>>& positions,
    const std::vector<std::array<std::uint32_t, 3>>& triangles,
    bool isSigned)
{
    isofront::bench::peers::PeerVoxels made;
    oneapi::tbb::task_arena(1).execute([&] {
        const Triangles mesh{positions, triangles};
        const auto transform = openvdb::math::Transform::createLinearTransform(1.0);
        const auto grid = openvdb::tools::meshToVolume<openvdb::FloatGrid>(
            mesh, *transform, 1.0F, 1.0F, isSigned ? 0 : openvdb::tools::UNSIGNED_DISTANCE_FIELD);
        made.voxels = grid->activeVoxelCount();
        made.bytes = grid->memUsage();
    });
    return made;
}
