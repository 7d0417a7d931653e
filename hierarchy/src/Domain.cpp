#include "isofront/hierarchy/Domain.h"

#include <glm/common.hpp>

namespace isofront::hierarchy {

GridPoint Domain::gridFromWorld(const glm::dvec3& world) const
{
    const double limit = std::ldexp(1.0, kGridBits + 16);
    const glm::dvec3 local = (worldFromField.inverse().point(world) - origin) / gridUnit();
    const glm::dvec3 bounded = glm::clamp(local, glm::dvec3(-limit), glm::dvec3(limit));
    return {std::llround(bounded.x), std::llround(bounded.y), std::llround(bounded.z)};
}

} // namespace isofront::hierarchy
