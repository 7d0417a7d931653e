#include "MipMap.h"

#include "LinearColour.h"

#include <algorithm>
#include <cmath>

namespace isofront::voxels {

namespace {

constexpr float kWhole = 65535.0F;

/// Where a coordinate lies within 0 to 1 of the texture.
double wrapped(double at, Texture::Wrap wrap)
{
    if (!std::isfinite(at))
        return 0;
    switch (wrap) {
    case Texture::Wrap::clamp:
        return std::clamp(at, 0.0, 1.0);
    case Texture::Wrap::mirror: {
        const double twice = at - 2 * std::floor(at / 2);
        return twice <= 1 ? twice : 2 - twice;
    }
    default:
        return at - std::floor(at);
    }
}

/// A pixel's index that may be one off the border, within it.
std::int64_t within(std::int64_t index, std::int64_t size, Texture::Wrap wrap)
{
    if (index >= 0 && index < size)
        return index;
    if (wrap == Texture::Wrap::repeat)
        return index < 0 ? size - 1 : 0;
    return std::clamp<std::int64_t>(index, 0, size - 1); // a mirrored one is its own neighbour
}

} // namespace

MipMap::MipMap(const Texture& texture) : _acrossX(texture.acrossX), _acrossY(texture.acrossY)
{
    const std::array<float, 256> linear = linearOfCodes();
    Level finest{texture.image.width, texture.image.height, {}};
    finest.pixels.resize(texture.image.rgba.size() / 4);
    for (std::size_t i = 0; i < finest.pixels.size(); ++i) {
        const std::uint8_t* const rgba = texture.image.rgba.data() + 4 * i;
        const float opacity = static_cast<float>(rgba[3]) / 255.0F;
        for (std::size_t channel = 0; channel < 3; ++channel)
            finest.pixels[i][channel] =
                static_cast<std::uint16_t>(kWhole * opacity * linear[rgba[channel]] + 0.5F);
        finest.pixels[i][3] = static_cast<std::uint16_t>(kWhole * opacity + 0.5F);
    }
    _levels.push_back(std::move(finest));
    while (_levels.back().width > 1 || _levels.back().height > 1)
        _levels.push_back(half(_levels.back()));
}

MipMap::Level MipMap::half(const Level& fine)
{
    Level coarse{(fine.width + 1) / 2, (fine.height + 1) / 2, {}};
    coarse.pixels.reserve(static_cast<std::size_t>(coarse.width * coarse.height));
    for (std::int64_t y = 0; y < coarse.height; ++y) {
        for (std::int64_t x = 0; x < coarse.width; ++x) {
            std::array<std::uint32_t, 4> sum{};
            std::uint32_t count = 0;
            for (std::int64_t j = 2 * y; j < std::min(2 * y + 2, fine.height); ++j)
                for (std::int64_t i = 2 * x; i < std::min(2 * x + 2, fine.width); ++i, ++count)
                    for (std::size_t channel = 0; channel < 4; ++channel)
                        sum[channel] +=
                            fine.pixels[static_cast<std::size_t>(j * fine.width + i)][channel];
            std::array<std::uint16_t, 4> mean{};
            for (std::size_t channel = 0; channel < 4; ++channel)
                mean[channel] = static_cast<std::uint16_t>((sum[channel] + count / 2) / count);
            coarse.pixels.push_back(mean);
        }
    }
    return coarse;
}

std::array<float, 4> MipMap::at(const glm::dvec2& place, double area) const
{
    // the level whose pixels, of 4^level of the finest, are nearest by their ratio
    std::size_t index = 0;
    double pixel = 1;
    for (; index + 1 < _levels.size() && area > 2 * pixel; ++index)
        pixel *= 4;
    const Level& level = _levels[index];
    const double scale = 1.0 / static_cast<double>(std::int64_t{1} << index);
    const double x =
        wrapped(place.x, _acrossX) * static_cast<double>(_levels[0].width) * scale - 0.5;
    const double y =
        wrapped(place.y, _acrossY) * static_cast<double>(_levels[0].height) * scale - 0.5;
    const auto column = static_cast<std::int64_t>(std::floor(x));
    const auto row = static_cast<std::int64_t>(std::floor(y));
    const auto right = static_cast<float>(x - std::floor(x));
    const auto down = static_cast<float>(y - std::floor(y));
    std::array<float, 4> colour{};
    for (std::int64_t j = 0; j < 2; ++j) {
        for (std::int64_t i = 0; i < 2; ++i) {
            const std::int64_t px = within(column + i, level.width, _acrossX);
            const std::int64_t py = within(row + j, level.height, _acrossY);
            const float weight = (i == 0 ? 1 - right : right) * (j == 0 ? 1 - down : down) / kWhole;
            const auto& values = level.pixels[static_cast<std::size_t>(py * level.width + px)];
            for (std::size_t channel = 0; channel < 4; ++channel)
                colour[channel] += weight * static_cast<float>(values[channel]);
        }
    }
    return colour;
}

} // namespace isofront::voxels
