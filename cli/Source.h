#pragma once

#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/volume/LoadVolume.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

namespace isofront::cli {

/// What a command works on, wherever it comes from.
struct Source {
    std::string name; ///< as the user wrote it
    std::string description;
    std::shared_ptr<const fields::Field> field;
    hierarchy::Domain domain;
    bool isProcedural = false;
    bool isTerrain = false;
    std::string terrainKind; ///< the preset of a terrain
    /// What the user's isovalue is if none is given, in the source's own units.
    double defaultIsovalue = 0;
    bool negated = false; ///< the field has the sign of the source's values turned
    /// Edge of a voxel along the index axes; 1 in index space. Nothing for procedural sources.
    std::optional<double> voxel;
    core::Box worldBox;  ///< what there is to see [world]
    glm::dvec3 eye{0.0}; ///< a good place to look from [world]
    glm::dvec3 target{0.0};
    std::optional<volume::LoadedVolume> volume;

    [[nodiscard]] double fieldIsovalue(double isovalue) const
    {
        return negated ? -isovalue : isovalue;
    }
};

struct SourceOptions {
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U; ///< [bytes]
    std::string grid = {};                               ///< of a VDB file
    std::stop_token stop;
};

/// The coarsest level 3k at which an axis step is at most this share of the domain's edge: that of
/// a volume's own voxels, for theirs.
int levelForStep(double share, int latticeSize);

/// Opens `proc:NAME[?key=value&...]` or a volume file.
/// Errors: usage for unknown names, parameters and kinds of file, and what loadVolume says.
core::Result<Source> openSource(const std::string& text, const SourceOptions& options);

} // namespace isofront::cli
