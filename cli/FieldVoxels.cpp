#include "FieldVoxels.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <string>

namespace isofront::cli {

namespace {

/// The least distance of a source's own voxels or posts [world].
double spacingOf(const Source& source)
{
    if (!source.volume)
        return *source.voxel;
    const glm::dmat3& axes = source.domain.worldFromField.linear;
    return std::min({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
}

} // namespace

core::Result<voxels::FieldVoxelizationSettings>
fieldVoxelSettings(const Source& source, const FieldVoxelOptions& options)
{
    voxels::FieldVoxelizationSettings settings;
    settings.isovalue = source.fieldIsovalue(options.isovalue.value_or(source.defaultIsovalue));
    settings.worldFromField = source.domain.worldFromField;
    settings.filterStrength = options.filter;
    settings.closed = options.closed;
    settings.box = source.worldBox;
    const glm::dvec3 size = source.worldBox.size();
    const double longest = std::max({size.x, size.y, size.z});
    if (!source.voxel) {
        if (options.resolution == 0)
            return core::failure(
                core::ErrorCode::usage,
                source.name + " has no voxels of its own: say how many with --resolution N");
        settings.edge = longest / options.resolution;
        return settings;
    }
    // its outermost samples are the middles of the outermost voxels
    if (options.resolution == 1)
        return core::failure(
            core::ErrorCode::usage,
            "--resolution 1: " + source.name + " needs at least 2 voxels along its longest edge");
    settings.edge = options.resolution == 0 || !(longest > 0) ? spacingOf(source)
                                                              : longest / (options.resolution - 1);
    settings.box.low -= 0.5 * settings.edge;
    settings.box.high += 0.5 * settings.edge;
    return settings;
}

} // namespace isofront::cli
