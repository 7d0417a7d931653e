#include "Assembly.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::volume {

using core::ErrorCode;

core::Result<void>
placeVolume(LoadedVolume& volume, const core::Affine& worldFromIndex, const core::Box& dataBox)
{
    VolumeInfo& info = volume.info;
    double spacingProduct = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        info.spacing[axis] = glm::length(worldFromIndex.linear[axis]);
        info.direction[axis] = worldFromIndex.linear[axis] / info.spacing[axis];
        spacingProduct *= info.spacing[axis];
    }
    info.origin = worldFromIndex.translation;
    // How far the axes are from lying in one plane: 1 if they are orthogonal.
    const double spread = std::abs(glm::determinant(info.direction));
    const double size = glm::length(info.origin);
    if (!(spread > 1e-9 && std::isfinite(spacingProduct) && spacingProduct > 0 &&
          std::isfinite(size)))
        return core::failure(
            ErrorCode::badData,
            "the header's spacing, directions and origin don't place the "
            "voxels in space; correct them in the file");

    volume.worldFromIndex = worldFromIndex;
    volume.dataBox = dataBox;
    info.dimensions = glm::ivec3(dataBox.size()) + 1;
    const double extent = std::max({dataBox.size().x, dataBox.size().y, dataBox.size().z});
    volume.domainEdge = 2;
    while (volume.domainEdge < extent)
        volume.domainEdge *= 2;
    volume.domainOrigin = dataBox.low;
    return {};
}

core::Result<void> checkFinite(const ValueSummary& values)
{
    if (values.finiteCount == 0)
        return core::failure(
            ErrorCode::badData,
            "none of the voxels has a finite value, so there is no surface to extract");
    return {};
}

core::Result<void> checkStop(const LoadOptions& options)
{
    if (options.stop.stop_requested())
        return core::failure(ErrorCode::interrupted, "loading was stopped");
    return {};
}

} // namespace isofront::volume
