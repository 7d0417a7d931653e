#include "SunBox.h"

#include "FrameData.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <cmath>

namespace isofront::render {

SunBox SunBox::seenFrom(const hierarchy::Domain& domain, const hierarchy::GridPoint& otherEye) const
{
    SunBox result = *this;
    const glm::dvec3 moved =
        domain.worldFromField.linear * domain.gridUnit() * glm::dvec3(eye - otherEye);
    for (std::size_t i = 0; i < 3; ++i)
        result.centre[i] += glm::dot(axes[i], moved);
    result.eye = otherEye;
    return result;
}

bool SunBox::isAlike(const SunBox& other) const
{
    return casts == other.casts && halfWidth == other.halfWidth && axes == other.axes;
}

bool SunBox::isNear(const SunBox& other) const
{
    bool near = isAlike(other);
    for (std::size_t i = 0; i < 2; ++i)
        near = near && std::abs(centre[i] - other.centre[i]) < 0.2 * halfWidth;
    return near;
}

SunBox
sunBox(const hierarchy::Domain& domain, const hierarchy::View& view, const Scene& scene, int texels)
{
    SunBox box;
    const glm::dvec3 sun = glm::normalize(scene.sunDirection);
    const bool isUp = glm::dot(sun, glm::normalize(scene.up)) > 0;
    const double reach = scene.shadowDistance * scene.terrain.metre;
    if (scene.look != Look::terrain || !isUp || !(reach > 0))
        return box;
    box.casts = true;
    // Most of the square lies before the eye.
    constexpr double kAhead = 0.5;
    box.halfWidth = 0.65 * reach;
    box.halfDepth = 4.0 * domain.edge * domain.worldFromField.stretch();
    const glm::dvec3 aside =
        std::abs(sun.z) < 0.9 ? glm::dvec3(0.0, 0.0, 1.0) : glm::dvec3(1.0, 0.0, 0.0);
    box.axes[0] = glm::normalize(glm::cross(aside, sun));
    box.axes[1] = glm::cross(box.axes[0], sun);
    box.axes[2] = sun;

    // Texels are counted from the domain's corner.
    box.eye = domain.gridFromWorld(view.eye);
    const glm::dvec3 eye = domain.worldFromField.linear * domain.gridUnit() * glm::dvec3(box.eye);
    const glm::dvec3 ahead = glm::normalize(view.forward) * (kAhead * reach);
    const double texel = 2.0 * box.halfWidth / texels;
    for (std::size_t i = 0; i < 2; ++i) {
        const double atEye = glm::dot(box.axes[i], eye);
        const double wanted = atEye + glm::dot(box.axes[i], ahead);
        box.centre[i] = std::round(wanted / texel) * texel - atEye;
    }
    return box;
}

GridView gridView(const hierarchy::Domain& domain, const hierarchy::View& view, const SunBox& box)
{
    GridView result;
    result.eye = domain.gridFromWorld(view.eye);
    result.worldFromGrid = domain.worldFromField.linear * domain.gridUnit();
    for (std::size_t i = 0; i < 2; ++i) {
        const glm::dvec3 side = glm::transpose(result.worldFromGrid) * box.axes[i];
        result.sides[2 * i] = side;
        result.offsets[2 * i] = box.halfWidth - box.centre[i];
        result.sides[2 * i + 1] = -side;
        result.offsets[2 * i + 1] = box.halfWidth + box.centre[i];
    }
    return result;
}

} // namespace isofront::render
