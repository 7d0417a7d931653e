#include "isofront/voxels/ChunkView.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::voxels {

bool ChunkView::isValid() const
{
    double sum = eye.x + eye.y + eye.z;
    for (const Plane& plane : planes)
        sum += plane.normal.x + plane.normal.y + plane.normal.z + plane.offset;
    return std::isfinite(sum) && std::isfinite(pixelsPerUnit) && pixelsPerUnit > 0 &&
           std::isfinite(nearest) && nearest > 0;
}

bool ChunkView::mayShow(const core::Box& box) const
{
    const glm::dvec3 low = box.low - eye;
    const glm::dvec3 high = box.high - eye;
    for (const Plane& plane : planes) {
        // the corner furthest on the inner side
        double most = plane.offset;
        for (std::size_t axis = 0; axis < 3; ++axis)
            most += plane.normal[axis] * (plane.normal[axis] > 0 ? high[axis] : low[axis]);
        if (most < 0)
            return false;
    }
    return true;
}

double ChunkView::distanceTo(const core::Box& box) const
{
    const glm::dvec3 to = glm::clamp(eye, box.low, box.high) - eye;
    return std::max(nearest, std::sqrt(glm::dot(to, to)));
}

ChunkView perspectiveView(
    const glm::dvec3& eye,
    const glm::dvec3& forward,
    const glm::dvec3& up,
    double verticalFieldOfView,
    int width,
    int height,
    double nearest)
{
    const glm::dvec3 ahead = glm::normalize(forward);
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, up));
    const glm::dvec3 above = glm::cross(right, ahead);
    const double tangentY = std::tan(0.5 * verticalFieldOfView);
    const double tangentX = tangentY * width / height;
    ChunkView view;
    view.eye = eye;
    view.planes = {{
        {right + tangentX * ahead, 0},
        {-right + tangentX * ahead, 0},
        {above + tangentY * ahead, 0},
        {-above + tangentY * ahead, 0},
        {ahead, -nearest},
        {}, // no far plane
    }};
    view.pixelsPerUnit = 0.5 * height / tangentY;
    view.nearest = nearest;
    return view;
}

} // namespace isofront::voxels
