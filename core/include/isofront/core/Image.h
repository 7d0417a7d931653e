#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::core {

/// A picture: rows from the top, four bytes a pixel (red, green, blue, opacity; sRGB).
struct Image {
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    std::vector<std::uint8_t> rgba;

    [[nodiscard]] const std::uint8_t* pixel(int x, int y) const
    {
        return rgba.data() + 4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                  static_cast<std::size_t>(x));
    }
};

} // namespace isofront::core
