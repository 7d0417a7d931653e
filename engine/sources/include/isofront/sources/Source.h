#pragma once

#include <isofront/core/Result.h>
#include <isofront/elevation/LoadElevation.h>
#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/volume/LoadVolume.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace isofront::sources {

/// A field to be shown, and where it lies, wherever it comes from.
struct Source {
    std::string name; ///< as the user wrote it
    /// The same in one way of writing, whatever the user left out and wherever a file lies: a
    /// formula with all parameters by name, as proc:torus?ring=0.75&tube=0.3; a file's name, with
    /// the grid or the detail that was chosen.
    std::string identity;
    std::string description;
    std::shared_ptr<const fields::Field> field;
    hierarchy::Domain domain;
    bool isProcedural = false;
    bool isTerrain = false;
    std::string terrainKind; ///< the preset of a terrain
    /// What the user's isovalue is if none is given, in the source's own units.
    double defaultIsovalue = 0;
    bool negated = false; ///< the field has the sign of the source's values turned
    /// Edge of a voxel along the index axes, 1 in index space; distance of an elevation raster's
    /// posts. Nothing for procedural sources.
    std::optional<double> voxel;
    /// How many levels below its voxels' own show all of the surface, if `voxel` has a value.
    int levelsBelowVoxel = 6;
    core::Box worldBox;  ///< what there is to see [world]
    glm::dvec3 eye{0.0}; ///< a good place to look from [world]
    glm::dvec3 target{0.0};
    glm::dvec3 up{0.0, 0.0, 1.0}; ///< of a picture [world]
    std::optional<volume::LoadedVolume> volume;
    std::optional<elevation::LoadedElevation> elevation;
    std::vector<std::string> notes; ///< sentences about choices made for the user

    [[nodiscard]] double fieldIsovalue(double isovalue) const
    {
        return negated ? -isovalue : isovalue;
    }
};

struct SourceOptions {
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U; ///< [bytes]
    std::string grid = {};                               ///< of a VDB file
    std::string series = {};                             ///< of a DICOM folder
    std::string rawLayout = {};                          ///< of a raw volume
    std::optional<glm::dvec3> voxelSize = {};            ///< of a dense volume [world]
    std::optional<glm::dvec2> pixelSize = {};            ///< of an elevation raster [m]
    std::optional<double> heightScale = {};              ///< of an elevation raster [m]
    std::optional<double> noData = {};                   ///< of an elevation raster
    std::string detail = "none";                         ///< added to an elevation raster
    int meshResolution = 256;                            ///< of a mesh: see LevelSetOptions
    std::optional<double> meshReach = {};                ///< of a mesh [world]
    /// Whether files that a mesh names are read. (Volumes' headers always are believed.)
    bool readsOtherFiles = true;
    std::stop_token stop = {};
};

/// Tells fields apart that have one identity, as of a file that has changed or was read with other
/// options: of values in a few thousand places, and where they lie. The same on any machine.
std::uint64_t checksumOf(const Source& source);

/// The coarsest level 3k at which an axis step is at most this share of the domain's edge: that of
/// a volume's own voxels, for theirs.
int levelForStep(double share, int latticeSize);

/// Opens `proc:NAME[?key=value&...]`, a volume, an elevation raster or a mesh. A mesh becomes the
/// distance from it (volume::levelSetOf), solid if it is closed, else a shell around its triangles.
/// Errors: usage for unknown names, parameters and kinds of file, and what loadVolume,
/// loadElevation, exchange::readModel and levelSetOf say.
core::Result<Source> openSource(const std::string& text, const SourceOptions& options);

} // namespace isofront::sources
