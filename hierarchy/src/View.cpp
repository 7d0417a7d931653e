#include "isofront/hierarchy/View.h"

#include <glm/geometric.hpp>

#include <cmath>
#include <numbers>

namespace isofront::hierarchy {

double View::pixelsPerUnit() const
{
    return height / (2.0 * std::tan(0.5 * verticalFieldOfView));
}

bool View::isValid() const
{
    const auto finite = [](const glm::dvec3& v) {
        return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    };
    return finite(eye) && finite(forward) && finite(up) && verticalFieldOfView > 0 &&
           verticalFieldOfView < std::numbers::pi && width > 0 && height > 0 &&
           glm::length(glm::cross(glm::normalize(forward), glm::normalize(up))) > 1e-9;
}

} // namespace isofront::hierarchy
