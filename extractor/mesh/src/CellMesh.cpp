#include "isofront/extractor/CellMesh.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

namespace isofront::extractor {

namespace {

constexpr double kScale = 32767.0;

double signOf(double value)
{
    return value < 0 ? -1.0 : 1.0;
}

} // namespace

std::array<std::int16_t, 2> octahedral(const glm::dvec3& unit)
{
    const double sum = std::abs(unit.x) + std::abs(unit.y) + std::abs(unit.z);
    double u = unit.x / sum;
    double v = unit.y / sum;
    if (unit.z < 0) {
        const double folded = (1.0 - std::abs(v)) * signOf(u);
        v = (1.0 - std::abs(u)) * signOf(v);
        u = folded;
    }
    const auto code = [](double value) {
        // std::lround without the call: halves away from zero
        const double scaled = std::clamp(value, -1.0, 1.0) * kScale;
        const auto whole = static_cast<int>(scaled);
        const double rest = scaled - whole;
        return static_cast<std::int16_t>(whole + (rest >= 0.5 ? 1 : 0) - (rest <= -0.5 ? 1 : 0));
    };
    return {code(u), code(v)};
}

glm::dvec3 fromOctahedral(const std::array<std::int16_t, 2>& code)
{
    double u = code[0] / kScale;
    double v = code[1] / kScale;
    const double z = 1.0 - std::abs(u) - std::abs(v);
    if (z < 0) {
        const double unfolded = (1.0 - std::abs(v)) * signOf(u);
        v = (1.0 - std::abs(u)) * signOf(v);
        u = unfolded;
    }
    return glm::normalize(glm::dvec3(u, v, z));
}

} // namespace isofront::extractor
