#pragma once

#include <glm/vec2.hpp>

#include <cstddef>
#include <vector>

namespace isofront::elevation {

/// Heights at the posts of a regular grid. Post (i, j) stands at `origin + spacing * (i, j)`.
struct HeightGrid {
    int columns = 0;            ///< posts from west to east, at least 2
    int rows = 0;               ///< posts from south to north, at least 2
    glm::dvec2 origin{0.0};     ///< of the south-western post, x east, y north [m]
    glm::dvec2 spacing{1.0};    ///< [m], > 0
    std::vector<float> heights; ///< [m] from west to east, then from south to north; finite

    [[nodiscard]] std::size_t index(int column, int row) const
    {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column);
    }
    /// From the first post to the last [m].
    [[nodiscard]] glm::dvec2 extent() const { return spacing * glm::dvec2(columns - 1, rows - 1); }
};

} // namespace isofront::elevation
