#pragma once

#include <isofront/core/Affine.h>
#include <isofront/core/Box.h>
#include <isofront/fields/Field.h>
#include <isofront/voxels/Voxelization.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>

namespace isofront::voxels {

struct FieldVoxelizationSettings {
    double isovalue = 0; ///< [field units]; solid is where the field is at or above it
    /// Where to look for the surface [world]. The lattice begins at its low corner.
    core::Box box;
    double edge = 1; ///< of a voxel [world]; at most kMaxResolution of them along the box
    /// From the field's own space; invertible. Voxels are cubes in the world, however the field
    /// lies in it.
    core::Affine worldFromField{};
    /// Scales the low-pass filter's radius, as for meshes: 0 samples the field as it is, 1 removes
    /// what voxels can't hold. At the default the radius is a voxel's edge, that of a mesh in a
    /// view whose lattice step it is.
    double filterStrength = 0.5;
    Separability separability = Separability::six;
    /// Close the solid where the data or the box end. Otherwise the surface ends there; what is
    /// inside the solid can't be seen either way.
    bool closed = false;
    /// Show both sides of every voxel.
    bool allFaces = false;
    /// Where chunks wait between the passes; empty for the system's folder for such.
    std::filesystem::path scratchFolder{};
};

struct FieldVoxelizationReport {
    VoxelLattice lattice;
    std::uint64_t voxels = 0;           ///< of level 0
    std::uint64_t allVoxels = 0;        ///< of all levels
    std::uint64_t chunks = 0;           ///< of all levels
    std::uint64_t emptyRegions = 0;     ///< parts of space that are closed off: solids and caves
    std::uint64_t scratchBytes = 0;     ///< what waited between the passes [bytes]
    std::uint64_t samples = 0;          ///< values asked of the field
    std::uint64_t sanitisedSamples = 0; ///< of them not finite, or huge
};

/// The lattice of a field: whole voxels from a box's low corner on.
VoxelLattice latticeOf(const FieldVoxelizationSettings& settings);

/// Turns the isosurface of a field into surface voxels of all levels of detail, chunk by chunk.
///
/// The field is sampled at the middles of voxels, filtered. Where two that are next to each other
/// lie on different sides of the surface, the field between the two cubes tells which of them the
/// surface passes through; that one is a voxel. So no path from face to face leads through the
/// surface, and each voxel holds a piece of it. What the field's bounds prove to be empty is not
/// sampled. The conservative voxels are, besides, all cubes whose corners and middle don't all lie
/// on one side.
///
/// Normals are those of the field, outward, and colours are its attributes as 0xBBGGRR; each
/// crossing counts for as much area as a surface of its direction has for one. A face can be seen
/// if the next cube is empty, and connected with the space around the box through empty cubes, as
/// for meshes; where the data end, the solid counts as closed even if it is not to be. So a cave
/// that is closed off isn't shown, and one that opens at the border is. Coarser levels are reduced
/// from finer ones, so each level contains all finer ones. A field without a surface gives no
/// chunk.
///
/// The same field gives the same chunks with any number of threads. NaN counts as outside.
///
/// Fails with `usage` for a box, edge or map that makes no sense, `inputOutput` for a full disk,
/// with what the sink says, and `interrupted`.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 3; S. Laine, "A topological approach to voxelization" (2013). Differs: the surface is
/// the field's, not that of triangles.
///
/// @param progress  told how much is done, from 0 to 1; may be null
core::Result<FieldVoxelizationReport> voxelizeField(
    const fields::Field& field,
    const FieldVoxelizationSettings& settings,
    ChunkSink& sink,
    core::Jobs& jobs,
    const std::atomic<bool>* cancelled = nullptr,
    const std::function<void(double)>& progress = nullptr);

} // namespace isofront::voxels
