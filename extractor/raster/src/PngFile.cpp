// Based on: the PNG specification (W3C, third edition); libpng's manual. libpng's simplified
// interface would apply the picture's gamma, and heights have none.

#include "isofront/raster/PngFile.h"

#include "isofront/raster/FileBytes.h"

#include <png.h>

#include <array>
#include <bit>
#include <cstdio>
#include <memory>
#include <string>
#include <system_error>

namespace isofront::raster {

namespace {

using core::ErrorCode;
using core::failure;

/// What libpng leaps out of, in case of an error; it has no destructor that a leap could miss.
struct Reading {
    png_structp png = nullptr;
    png_infop info = nullptr;
    std::array<char, 160> message{};
};

void keepMessage(png_structp png, png_const_charp text)
{
    auto& reading = *static_cast<Reading*>(png_get_error_ptr(png));
    std::snprintf(reading.message.data(), reading.message.size(), "%s", text);
    png_longjmp(png, 1);
}

void dropMessage(png_structp, png_const_charp) {}

/// The header's four numbers; false after an error.
bool readHeader(
    Reading& reading,
    std::FILE* file,
    png_uint_32& width,
    png_uint_32& height,
    int& bits,
    int& colour)
{
    if (setjmp(png_jmpbuf(reading.png)) != 0)
        return false;
    png_init_io(reading.png, file);
    png_set_user_limits(reading.png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_read_info(reading.png, reading.info);
    png_get_IHDR(
        reading.png, reading.info, &width, &height, &bits, &colour, nullptr, nullptr, nullptr);
    return true;
}

/// All rows, as 16-bit values of this machine's byte order; false after an error.
bool readRows(Reading& reading, png_bytep* rows, int bits)
{
    if (setjmp(png_jmpbuf(reading.png)) != 0)
        return false;
    if (bits == 16) {
        if (std::endian::native == std::endian::little)
            png_set_swap(reading.png);
    } else {
        png_set_packing(reading.png); // one byte a pixel, not scaled
    }
    png_read_image(reading.png, rows);
    png_read_end(reading.png, nullptr);
    return true;
}

} // namespace

core::Result<GreyPicture> readGreyPng(const std::filesystem::path& path, std::uint64_t memoryLimit)
{
    if (const auto readable = checkReadable(path); !readable)
        return tl::unexpected(readable.error());
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
        std::fopen(path.c_str(), "rb"), std::fclose);
    if (!file)
        return failure(ErrorCode::inputOutput, "the file can't be opened; check its permissions");

    Reading reading;
    reading.png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reading, keepMessage, dropMessage);
    reading.info = reading.png != nullptr ? png_create_info_struct(reading.png) : nullptr;
    const auto closed = [](Reading* r) { png_destroy_read_struct(&r->png, &r->info, nullptr); };
    const std::unique_ptr<Reading, decltype(closed)> closing(&reading, closed);
    if (reading.info == nullptr)
        return failure(
            ErrorCode::resourceLimit, "there is no memory left to read the picture; free some");
    const auto damaged = [&] {
        return failure(
            ErrorCode::badData,
            std::string("the file can't be read as PNG (") + reading.message.data() +
                "); export it again");
    };

    png_uint_32 width = 0;
    png_uint_32 height = 0;
    int bits = 0;
    int colour = 0;
    if (!readHeader(reading, file.get(), width, height, bits, colour))
        return damaged();
    if (colour != PNG_COLOR_TYPE_GRAY)
        return failure(
            ErrorCode::badData,
            "its pixels are not grey values alone; export heights as 16-bit grey without opacity");
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    const std::uint64_t pixels = std::uint64_t{width} * height;
    std::error_code failed;
    const std::uint64_t fileBytes = std::filesystem::file_size(path, failed);
    constexpr std::uint64_t kBestRatio = 1032; // of deflate
    if (pixels * static_cast<std::uint64_t>(bits) / 8 / kBestRatio > fileBytes)
        return failure(
            ErrorCode::badData,
            "the header promises " + size + " pixels, but the file has only " +
                std::to_string(fileBytes) + " bytes; it is cut short, or its header is wrong");
    if (pixels > memoryLimit / sizeof(std::uint16_t))
        return failure(
            ErrorCode::resourceLimit,
            size + " pixels take more than the memory limit of " + std::to_string(memoryLimit) +
                " bytes; raise the limit or reduce the picture");

    GreyPicture picture;
    picture.width = static_cast<int>(width);
    picture.height = static_cast<int>(height);
    picture.bits = bits;
    picture.values.resize(pixels);
    const std::size_t bytesPerPixel = bits == 16 ? 2 : 1;
    std::vector<std::uint8_t> bytes(bits == 16 ? 0 : pixels);
    auto* first = bits == 16 ? reinterpret_cast<png_bytep>(picture.values.data()) : bytes.data();
    std::vector<png_bytep> rows(height);
    for (png_uint_32 row = 0; row < height; ++row)
        rows[row] = first + std::size_t{row} * width * bytesPerPixel;
    if (!readRows(reading, rows.data(), bits))
        return damaged();
    for (std::size_t i = 0; i < bytes.size(); ++i)
        picture.values[i] = bytes[i];
    return picture;
}

} // namespace isofront::raster
