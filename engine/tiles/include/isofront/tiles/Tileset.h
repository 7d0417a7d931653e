#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace isofront::tiles {

/// The most levels of a tileset.
inline constexpr int kMostLevels = 12;

struct TilesetOptions {
    /// Of tiles, 1 to `kMostLevels`: the first has one tile, the domain; the tiles of each other
    /// one, and their lattice steps, are half as long.
    int levels = 4;
    /// Lattice steps along the edge of a tile: a power of two, at least two lattice sizes and at
    /// most 1024.
    int tileSteps = 64;
    /// Filter strength of all levels but the finest, which has that of the extraction's settings.
    double coarseFilter = 0.5;
    /// What is nearer to the surface than this isn't refined [world]; 0 refines all.
    double maxError = 0;
    /// Of the finest level; it gives way to the next coarser one as long as it has more. 0 for any
    /// number.
    std::size_t maxTriangles = 0;
    /// What the mesh of a level may take [bytes].
    std::size_t memoryLimit = std::size_t{8} << 30U;
    std::string name = "isosurface"; ///< of the meshes
    /// How the tileset was made, as key and value: extras of its asset.
    std::vector<std::pair<std::string, std::string>> settings;
    /// Called now and then from the calling thread: what is being done, and a share in [0, 1], or
    /// less than 0 where none can be told.
    std::function<void(const std::string&, double)> progress;
    std::stop_token stop;
};

struct TilesetLevel {
    std::uint64_t tiles = 0;     ///< that have a mesh
    std::uint64_t triangles = 0; ///< in their files
    double step = 0;             ///< of the lattice [world]
    double error = 0;            ///< the largest geometric error of its tiles [world]
    double measuredError = 0;    ///< the largest distance that was measured [world]
};

struct TilesetReport {
    std::vector<TilesetLevel> levels; ///< the coarsest first
    std::uint64_t bytes = 0;          ///< of all files
    std::uint64_t files = 0;
    int levelsAskedFor = 0;
    core::Box bounds; ///< of all triangles [world]; empty if there are none
    std::uint64_t sanitisedSamples = 0;
    std::vector<std::string> warnings; ///< one sentence each
};

/// Writes the surface of a field at several levels of detail as a tileset, which a client refines
/// where it looks closely.
///
/// The tiles are the cubes of a regular octree over the domain. Every third level of the bisection
/// fills such cubes with whole cells, so a tile of depth d is the mesh of the cells of one level in
/// its cube, and tiles of one depth together are just the mesh that `surface::extractMesh` makes of
/// that level. A tile also has the triangles of its neighbours that come within one of its lattice
/// steps of the cube. So tiles of different depths overlap by more than they differ, and no gap
/// opens between them even where the surface runs along a border; a skirt, which hangs from the
/// line in which a surface meets a border, can't close those. Triangles that two neighbours of one
/// depth both show are the same to the last bit but for the rounding of floats.
///
/// The geometric error of a tile is the largest distance from the unfiltered surface that was
/// measured in the middles of its triangles, one lattice step at most; a whole step where it lacks
/// what one of its children shows, or where the next level has nothing, which a child without
/// content says; and no less than that of any child. It is 0 for tiles without children. World
/// units are taken as metres. World space is the tileset's, z up; meshes have y up, as glTF wants,
/// and clients turn them back.
///
/// `folder` must be new or empty, and appears when all is written: until then, and forever if it
/// fails or is interrupted, nothing is there. The files don't depend on the number of threads, to
/// the last byte.
///
/// Memory: the mesh of the finest level, and half as much again.
/// Errors: usage (options out of range), inputOutput, resourceLimit and interrupted as
/// `surface::extractMesh` says, or more than `maxTriangles` in the only tile of the first level.
///
/// Source: Open Geospatial Consortium, "3D Tiles Specification", version 1.1 (22-025r4), sections
/// on tiles, geometric error and refinement. Khronos Group, "glTF 2.0 Specification".
core::Result<TilesetReport> writeTileset(
    std::shared_ptr<const fields::Field> field,
    const hierarchy::Domain& domain,
    const extractor::ExtractionSettings& settings,
    core::Jobs& jobs,
    const TilesetOptions& options,
    const std::filesystem::path& folder);

} // namespace isofront::tiles
