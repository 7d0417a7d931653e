// Based on: ISO/IEC 15948 (PNG), section 11.2.2; ITU-T T.81 (JPEG), annex B.

#include "Picture.h"

#include <isofront/raster/FileBytes.h>

#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>

namespace isofront::exchange {

namespace {

struct Size {
    std::uint64_t width = 0;
    std::uint64_t height = 0;
};

std::uint64_t bigEndian(std::span<const std::byte> bytes)
{
    std::uint64_t number = 0;
    for (const std::byte byte : bytes)
        number = number << 8U | static_cast<std::uint64_t>(byte);
    return number;
}

std::optional<Size> sizeOfPng(std::span<const std::byte> bytes)
{
    constexpr std::array<unsigned char, 8> kSignature{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    constexpr std::size_t kSizeAt = 16;
    constexpr std::uint64_t kHeader = 0x49484452; // "IHDR", which has to be the first chunk
    if (bytes.size() < kSizeAt + 8 || bigEndian(bytes.subspan(kSizeAt - 4, 4)) != kHeader ||
        !std::ranges::equal(kSignature, bytes.first(8), {}, {}, [](std::byte b) {
            return static_cast<unsigned char>(b);
        }))
        return std::nullopt;
    return Size{bigEndian(bytes.subspan(kSizeAt, 4)), bigEndian(bytes.subspan(kSizeAt + 4, 4))};
}

/// From the frame header, past the segments before it.
std::optional<Size> sizeOfJpeg(std::span<const std::byte> bytes)
{
    if (bytes.size() < 4 || bigEndian(bytes.first(2)) != 0xffd8)
        return std::nullopt;
    for (std::size_t at = 2; at + 9 <= bytes.size();) {
        const std::uint64_t marker = bigEndian(bytes.subspan(at, 2));
        if (marker == 0xffff) { // a fill byte
            ++at;
            continue;
        }
        if (marker < 0xff01)
            return std::nullopt;
        const bool isFrame = marker >= 0xffc0 && marker <= 0xffcf && marker != 0xffc4 &&
                             marker != 0xffc8 && marker != 0xffcc;
        if (isFrame)
            return Size{bigEndian(bytes.subspan(at + 7, 2)), bigEndian(bytes.subspan(at + 5, 2))};
        at += 2 + bigEndian(bytes.subspan(at + 2, 2));
    }
    return std::nullopt;
}

} // namespace

core::Result<core::Image> decodePicture(std::span<const std::byte> bytes, std::uint64_t mostBytes)
{
    std::optional<Size> size = sizeOfPng(bytes);
    if (!size)
        size = sizeOfJpeg(bytes);
    if (!size || bytes.size() > 0x7fffffffU)
        return core::failure(
            core::ErrorCode::badData, "it is neither a PNG nor a JPEG picture; convert it");
    if (size->width * size->height > std::min<std::uint64_t>(mostBytes / 4, 1U << 29U))
        return core::failure(
            core::ErrorCode::resourceLimit,
            "it says that it has " + std::to_string(size->width) + " x " +
                std::to_string(size->height) + " pixels, more than are allowed for");
    tinygltf::Image decoded;
    std::string error;
    std::string warning;
    if (!tinygltf::LoadImageData(
            &decoded,
            0,
            &error,
            &warning,
            0,
            0,
            reinterpret_cast<const unsigned char*>(bytes.data()),
            static_cast<int>(bytes.size()),
            nullptr) ||
        decoded.width < 1 || decoded.height < 1)
        return core::failure(core::ErrorCode::badData, "it is damaged");
    if (static_cast<std::uint64_t>(decoded.width) != size->width ||
        static_cast<std::uint64_t>(decoded.height) != size->height)
        return core::failure(core::ErrorCode::badData, "it has another size than it says");
    core::Image image;
    image.width = decoded.width;
    image.height = decoded.height;
    const std::size_t values =
        4 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t step = decoded.bits == 16 ? 2 : 1;
    if (decoded.component != 4 || decoded.image.size() != values * step)
        return core::failure(core::ErrorCode::badData, "it has channels that are not known");
    if (step == 1) {
        image.rgba = std::move(decoded.image);
        return image;
    }
    image.rgba.resize(values);
    for (std::size_t i = 0; i < values; ++i) // words of this machine, which is little-endian
        image.rgba[i] = decoded.image[2 * i + 1];
    return image;
}

core::Result<core::Image> readPicture(const std::filesystem::path& path, std::uint64_t mostBytes)
{
    const auto bytes = raster::readFileBytes(path, mostBytes, core::ErrorCode::resourceLimit);
    if (!bytes)
        return tl::unexpected(bytes.error().within(path.string()));
    auto image = decodePicture(*bytes, mostBytes);
    if (!image)
        return tl::unexpected(image.error().within(path.string()));
    return image;
}

} // namespace isofront::exchange
