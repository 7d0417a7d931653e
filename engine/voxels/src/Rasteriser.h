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
    /// A triangle with its corners at hand.
    struct Placed {
        std::array<std::array<std::int32_t, 3>, 3> corners{}; ///< [steps]
        std::uint32_t index = 0;                              ///< in the model
    };

    /// The lowest of the grid's layers that a triangle may touch.
    static std::size_t layersOf(const Placed& placed, const VoxelRange& within);
    void sort(
        const LatticeModel& model,
        std::span<const std::uint32_t> triangles,
        const VoxelRange& within);
    void
    add(const LatticeModel& model,
        std::uint32_t index,
        const LatticeTriangle& triangle,
        const VoxelRange& within);
    void addToFaces(const std::array<std::uint32_t, 3>& place, const WeightedFace& part);
    void mark(const LatticeTriangle& triangle, const VoxelRange& within);
    void addFaces(
        const LatticeModel& model,
        std::span<const std::uint32_t> triangles,
        const VoxelRange& within,
        VoxelList& list);

    VoxelGrid _grid;
    std::vector<Placed> _placed;                               ///< in the order given
    std::vector<std::uint32_t> _order;                         ///< of those, by layers
    std::array<std::uint32_t, VoxelGrid::kTakes + 1> _begin{}; ///< of the layers in that order
    std::vector<TrianglePart> _parts;                          ///< of a triangle
    CrosshairHits _hits{};                                     ///< of its crosshairs
    /// While faces are added: those of the voxels that get them, by their order.
    std::unordered_map<std::uint32_t, WeightedFaces*> _facesOf;
};

} // namespace isofront::voxels
