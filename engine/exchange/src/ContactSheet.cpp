#include "isofront/exchange/ContactSheet.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::exchange {

namespace {

constexpr int kMargin = 4; // [px]
constexpr std::array<std::uint8_t, 4> kBackground{24, 26, 29, 255};

/// IEC 61966-2-1 (sRGB), section 5.2.
double linearFromSrgb(double value)
{
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

double srgbFromLinear(double value)
{
    return value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
}

std::uint8_t byteFrom(double value)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
}

const std::array<double, 256>& linearOfByte()
{
    static const std::array<double, 256> table = [] {
        std::array<double, 256> values{};
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = linearFromSrgb(static_cast<double>(i) / 255);
        return values;
    }();
    return table;
}

/// The source pixels under each target pixel along one axis, and how much of each.
struct Cover {
    int first = 0;
    std::vector<double> weights;
};

std::vector<Cover> covers(int source, int target)
{
    std::vector<Cover> result(static_cast<std::size_t>(target));
    const double scale = static_cast<double>(source) / target;
    for (int i = 0; i < target; ++i) {
        const double low = i * scale;
        const double high = std::min<double>((i + 1) * scale, source);
        Cover& cover = result[static_cast<std::size_t>(i)];
        cover.first = std::min(static_cast<int>(low), source - 1);
        for (int pixel = cover.first; pixel < source && pixel < high; ++pixel)
            cover.weights.push_back(
                std::min<double>(high, pixel + 1) - std::max<double>(low, pixel));
    }
    return result;
}

bool hasPixels(const core::Image& image)
{
    return image.width > 0 && image.height > 0 &&
           image.rgba.size() ==
               4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
}

std::uint8_t* pixelOf(core::Image& image, int x, int y)
{
    return image.rgba.data() + (image.pixel(x, y) - image.rgba.data());
}

core::Image filled(int width, int height)
{
    core::Image image{width, height, {}};
    image.rgba.resize(4 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (std::size_t byte = 0; byte < image.rgba.size(); ++byte)
        image.rgba[byte] = kBackground[byte % 4];
    return image;
}

} // namespace

core::Image resampled(const core::Image& image, int width, int height)
{
    ISOFRONT_ASSERT(hasPixels(image), "the image to resample has no pixels");
    ISOFRONT_ASSERT(width > 0 && height > 0, "an image has at least one pixel a side");
    const std::vector<Cover> columns = covers(image.width, width);
    const std::vector<Cover> rows = covers(image.height, height);
    core::Image result = filled(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const Cover& column = columns[static_cast<std::size_t>(x)];
            const Cover& row = rows[static_cast<std::size_t>(y)];
            double area = 0;
            double opacity = 0;
            std::array<double, 3> light{};
            for (std::size_t j = 0; j < row.weights.size(); ++j) {
                const std::uint8_t* pixel =
                    image.pixel(column.first, row.first + static_cast<int>(j));
                for (std::size_t i = 0; i < column.weights.size(); ++i, pixel += 4) {
                    const double weight = row.weights[j] * column.weights[i];
                    const double solid = weight * pixel[3] / 255;
                    area += weight;
                    opacity += solid;
                    for (std::size_t channel = 0; channel < 3; ++channel)
                        light[channel] += solid * linearOfByte()[pixel[channel]];
                }
            }
            std::uint8_t* target = pixelOf(result, x, y);
            for (std::size_t channel = 0; channel < 3; ++channel)
                target[channel] =
                    opacity > 0 ? byteFrom(srgbFromLinear(light[channel] / opacity)) : 0;
            target[3] = byteFrom(opacity / area);
        }
    return result;
}

core::Image contactSheet(std::span<const core::Image> images, int columns, int thumbnailWidth)
{
    ISOFRONT_ASSERT(columns > 0 && thumbnailWidth > 0, "a contact sheet needs columns and a width");
    if (images.empty())
        return {};
    const auto heightAt = [](const core::Image& image, int width) {
        const double ratio = static_cast<double>(image.height) / image.width;
        return std::max(1, static_cast<int>(std::lround(width * ratio)));
    };
    const int count = static_cast<int>(images.size());
    const int across = std::min(columns, count);
    const int down = (count + across - 1) / across;
    const int placeHeight = heightAt(images.front(), thumbnailWidth);
    core::Image sheet = filled(
        kMargin + across * (thumbnailWidth + kMargin), kMargin + down * (placeHeight + kMargin));
    for (int i = 0; i < count; ++i) {
        const core::Image& image = images[static_cast<std::size_t>(i)];
        int width = thumbnailWidth;
        int height = heightAt(image, width);
        if (height > placeHeight) {
            height = placeHeight;
            width = std::clamp(
                static_cast<int>(
                    std::lround(static_cast<double>(placeHeight) * image.width / image.height)),
                1,
                thumbnailWidth);
        }
        const core::Image thumbnail = resampled(image, width, height);
        const int left =
            kMargin + i % across * (thumbnailWidth + kMargin) + (thumbnailWidth - width) / 2;
        const int top = kMargin + i / across * (placeHeight + kMargin) + (placeHeight - height) / 2;
        for (int y = 0; y < height; ++y)
            std::copy_n(
                thumbnail.pixel(0, y),
                4 * static_cast<std::size_t>(width),
                pixelOf(sheet, left, top + y));
    }
    return sheet;
}

} // namespace isofront::exchange
