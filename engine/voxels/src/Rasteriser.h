#pragma once

#include "CrosshairKernel.h"
#include "LatticeModel.h"
#include "TriangleKernel.h"
#include "VoxelGrid.h"

#include <span>
#include <unordered_map>
#include <vector>

namespace isofront::voxels {

/// Turns triangles into the voxels of a chunk. Thread: one at a time.
class Rasteriser {
public:
    /// @param chunk      its place among the chunks of level 0
    /// @param triangles  those whose box meets the chunk, in increasing order
    /// @param list       gets the voxels, without face masks; those whose triangles are turned to
    ///                   different sides with what can be seen from each side
    /// @param touched    how many cubes the triangles touch is added to it
    void
    run(const LatticeModel& model,
        const std::array<std::uint32_t, 3>& chunk,
        std::span<const std::uint32_t> triangles,
        Separability separability,
        VoxelList& list,
        std::uint64_t& touched);

private:
    void add(const LatticeModel& model, std::uint32_t index, const VoxelRange& within);
    void addToFaces(const std::array<std::uint32_t, 3>& place, const WeightedFace& part);
    void mark(const LatticeTriangle& triangle, const VoxelRange& within);
    void addFaces(
        const LatticeModel& model,
        std::span<const std::uint32_t> triangles,
        const VoxelRange& within,
        VoxelList& list);

    VoxelGrid _grid;
    std::vector<TrianglePart> _parts; ///< of a triangle
    std::vector<RangePlace> _hits;    ///< of its crosshairs
    /// While faces are added: those of the voxels that get them, by their order.
    std::unordered_map<std::uint32_t, WeightedFaces*> _facesOf;
};

} // namespace isofront::voxels
