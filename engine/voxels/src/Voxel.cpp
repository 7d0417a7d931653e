#include <isofront/voxels/Voxel.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::voxels {

namespace {

constexpr int kBits = 10;
constexpr double kScale = (1 << (kBits - 1)) - 1;
constexpr std::uint32_t kMask = (1U << kBits) - 1;

std::uint32_t coded(double value)
{
    // halves away from zero, so that opposite normals stay opposite; the number below one half, as
    // adding that to the number below it would give one
    constexpr double kHalf = 0.49999999999999994;
    const double scaled = value * kScale;
    return static_cast<std::uint32_t>(
               static_cast<std::int32_t>(scaled + std::copysign(kHalf, scaled))) &
           kMask;
}

double decoded(std::uint32_t bits)
{
    const auto value = static_cast<std::int32_t>(bits & kMask);
    return value < 1 << (kBits - 1) ? value : value - (1 << kBits);
}

} // namespace

std::uint32_t packNormal(const glm::dvec3& direction)
{
    const double most =
        std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
    glm::dvec3 unit(0, 0, 1);
    if (most > 0 && std::isfinite(direction.x + direction.y + direction.z)) {
        // first to a size whose square neither vanishes nor overflows
        const glm::dvec3 scaled = direction / most;
        unit = scaled / std::sqrt(glm::dot(scaled, scaled));
    }
    return coded(unit.x) | coded(unit.y) << kBits | coded(unit.z) << 2 * kBits;
}

glm::dvec3 unpackNormal(std::uint32_t packed)
{
    const glm::dvec3 v(decoded(packed), decoded(packed >> kBits), decoded(packed >> 2 * kBits));
    const double squared = glm::dot(v, v);
    return squared > 0 ? v / std::sqrt(squared) : glm::dvec3(0, 0, 1);
}

} // namespace isofront::voxels
