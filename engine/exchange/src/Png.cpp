// Based on: the simplified interface of libpng 1.6, which catches its own long jumps and so never
// leaps over a destructor of ours.

#include "isofront/exchange/Png.h"

#include "isofront/exchange/OutputFile.h"

#include <png.h>

#include <cerrno>
#include <cstddef>
#include <fstream>
#include <iterator>
#include <new>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace isofront::exchange {

namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28U;

/// Frees what libpng holds, on every way out.
class PngImage {
public:
    PngImage() { image.version = PNG_IMAGE_VERSION; }
    PngImage(const PngImage&) = delete;
    PngImage& operator=(const PngImage&) = delete;
    ~PngImage() { png_image_free(&image); }

    png_image image{};
};

bool isOpaque(const core::Image& image)
{
    for (std::size_t byte = 3; byte < image.rgba.size(); byte += 4)
        if (image.rgba[byte] != 255)
            return false;
    return true;
}

std::vector<std::uint8_t> withoutOpacity(const core::Image& image)
{
    std::vector<std::uint8_t> rgb;
    rgb.reserve(image.rgba.size() / 4 * 3);
    for (std::size_t byte = 0; byte < image.rgba.size(); byte += 4)
        rgb.insert(rgb.end(), {image.rgba[byte], image.rgba[byte + 1], image.rgba[byte + 2]});
    return rgb;
}

core::Result<std::vector<char>> readBytes(const std::filesystem::path& path)
{
    const auto unreadable = [&](const std::string& why) {
        return core::failure(
            core::ErrorCode::inputOutput,
            "can't read \"" + path.string() + "\": " + why + "; check the path");
    };
    std::error_code failure;
    if (std::filesystem::is_directory(path, failure))
        return unreadable("it is a folder");
    std::ifstream file(path, std::ios::binary);
    if (!file)
        return unreadable(std::generic_category().message(errno));
    std::vector<char> bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    if (file.bad())
        return unreadable(std::generic_category().message(errno));
    return bytes;
}

} // namespace

core::Result<std::uint64_t> writePng(const core::Image& image, const std::filesystem::path& path)
{
    const std::uint64_t pixels =
        image.width > 0 && image.height > 0
            ? static_cast<std::uint64_t>(image.width) * static_cast<std::uint64_t>(image.height)
            : 0;
    if (pixels == 0 || image.rgba.size() != 4 * pixels)
        return core::failure(
            core::ErrorCode::usage,
            "can't write \"" + path.string() + "\": an image of " + std::to_string(image.width) +
                " x " + std::to_string(image.height) + " pixels with " +
                std::to_string(image.rgba.size()) + " bytes is no picture; it needs four a pixel");

    core::Result<OutputFile> file = OutputFile::create(path);
    if (!file)
        return tl::unexpected(file.error());

    const bool opaque = isOpaque(image);
    const std::vector<std::uint8_t> rgb =
        opaque ? withoutOpacity(image) : std::vector<std::uint8_t>{};
    PngImage png;
    png.image.width = static_cast<png_uint_32>(image.width);
    png.image.height = static_cast<png_uint_32>(image.height);
    png.image.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
    std::vector<std::byte> encoded(PNG_IMAGE_PNG_SIZE_MAX(png.image));
    png_alloc_size_t size = encoded.size();
    const void* source = opaque ? rgb.data() : image.rgba.data();
    if (png_image_write_to_memory(&png.image, encoded.data(), &size, 0, source, 0, nullptr) == 0)
        return core::failure(
            core::ErrorCode::resourceLimit,
            "can't encode \"" + path.string() + "\": " + png.image.message +
                "; write a smaller picture");
    file->write(std::span(encoded).first(size));
    return file->commit();
}

core::Result<core::Image> readPng(const std::filesystem::path& path)
{
    const core::Result<std::vector<char>> bytes = readBytes(path);
    if (!bytes)
        return tl::unexpected(bytes.error());

    PngImage png;
    const auto damaged = [&] {
        return core::failure(
            core::ErrorCode::badData,
            "can't read \"" + path.string() + "\" as PNG: " + png.image.message +
                "; export the picture again");
    };
    if (png_image_begin_read_from_memory(&png.image, bytes->data(), bytes->size()) == 0)
        return damaged();
    const std::uint64_t pixels = std::uint64_t{png.image.width} * png.image.height;
    if (pixels > kMostPixels)
        return core::failure(
            core::ErrorCode::resourceLimit,
            "\"" + path.string() + "\" has " + std::to_string(png.image.width) + " x " +
                std::to_string(png.image.height) + " pixels; at most 2^28 are read");
    png.image.format = PNG_FORMAT_RGBA;
    core::Image image;
    image.width = static_cast<int>(png.image.width);
    image.height = static_cast<int>(png.image.height);
    image.rgba.resize(4 * pixels);
    if (png_image_finish_read(&png.image, nullptr, image.rgba.data(), 0, nullptr) == 0)
        return damaged();
    return image;
}

} // namespace isofront::exchange
