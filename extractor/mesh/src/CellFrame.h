#pragma once

#include <isofront/hierarchy/Domain.h>

#include <glm/vec3.hpp>

#include <cstdint>

namespace isofront::extractor {

/// The box of a cell as coordinates for work inside it: cell units from the low corner, in which
/// vertices are integers from 0 to 32768.
struct CellFrame {
    hierarchy::GridPoint corner{}; ///< [grid units]
    int exponent = 1;              ///< a cell unit is 2^exponent grid units

    static constexpr std::int64_t kSize = 32768;
    static constexpr glm::dvec3 kMiddle{kSize / 2.0, kSize / 2.0, kSize / 2.0};

    [[nodiscard]] glm::dvec3 local(const hierarchy::GridPoint& p) const
    {
        return glm::dvec3((p - corner) >> std::int64_t{exponent});
    }
    [[nodiscard]] hierarchy::GridPoint grid(const glm::i64vec3& units) const
    {
        return corner + (units << std::int64_t{exponent});
    }
};

} // namespace isofront::extractor
