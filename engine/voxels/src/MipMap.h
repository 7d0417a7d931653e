#pragma once

#include <isofront/voxels/TriangleModel.h>

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// A texture and its halves: each level has the means of two by two pixels of the one before.
///
/// Colours are linear and weighted by opacity, so that means are those of light. Bits depend on the
/// picture and the arguments alone. Thread: any number at once.
class MipMap {
public:
    explicit MipMap(const Texture& texture);

    /// The colour around a place, by the pixels of the level whose pixels are nearest to an area.
    /// @param place  as in TriangleModel::textureCorners; what is not finite counts as 0
    /// @param area   to take the mean of [pixels]
    [[nodiscard]] std::array<float, 4> at(const glm::dvec2& place, double area) const;

    /// Pixels of the whole texture.
    [[nodiscard]] double pixels() const
    {
        return static_cast<double>(_levels[0].width) * static_cast<double>(_levels[0].height);
    }

private:
    struct Level {
        std::int64_t width = 0;
        std::int64_t height = 0;
        std::vector<std::array<std::uint16_t, 4>> pixels;
    };
    static Level half(const Level& fine);

    std::vector<Level> _levels;
    Texture::Wrap _acrossX;
    Texture::Wrap _acrossY;
};

} // namespace isofront::voxels
