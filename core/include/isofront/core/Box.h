#pragma once

#include <glm/common.hpp>
#include <glm/vec3.hpp>

#include <limits>

namespace isofront::core {

/// An axis-aligned box; empty while `low` exceeds `high` on an axis.
struct Box {
    glm::dvec3 low{std::numeric_limits<double>::infinity()};
    glm::dvec3 high{-std::numeric_limits<double>::infinity()};

    [[nodiscard]] bool isEmpty() const
    {
        return !(low.x <= high.x && low.y <= high.y && low.z <= high.z);
    }
    void include(const glm::dvec3& point)
    {
        low = glm::min(low, point);
        high = glm::max(high, point);
    }
    [[nodiscard]] glm::dvec3 centre() const { return 0.5 * (low + high); }
    [[nodiscard]] glm::dvec3 size() const { return high - low; }
};

/// A closed interval of numbers.
struct Interval {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();

    [[nodiscard]] bool contains(double value) const { return low <= value && value <= high; }
};

} // namespace isofront::core
