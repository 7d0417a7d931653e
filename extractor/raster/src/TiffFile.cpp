// Based on: TIFF 6.0 (Adobe); OGC GeoTIFF 1.1 (19-008r4) for the geographic tags; libtiff's manual.

#include "isofront/raster/TiffFile.h"

#include "isofront/raster/FileBytes.h"

#include <isofront/core/Assert.h>

#include <tiffio.h>

#include <algorithm>
#include <array>
#include <cstdarg>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

namespace isofront::raster {

namespace {

using core::ErrorCode;
using core::failure;

constexpr std::uint32_t kPixelScaleTag = 33550;
constexpr std::uint32_t kTiepointTag = 33922;
constexpr std::uint32_t kTransformationTag = 34264;
constexpr std::uint32_t kGeoKeysTag = 34735;
constexpr std::uint32_t kNoDataTag = 42113;
/// A page's sides must fit an int, and some arithmetic on them.
constexpr std::uint32_t kMostPixels = std::uint32_t{1} << 30U;
constexpr std::size_t kMostPages = 65536;

/// libtiff tells through callbacks; the first message of an operation is the cause.
struct Messages {
    std::string first;

    static int keep(TIFF*, void* user, const char*, const char* format, va_list arguments)
    {
        auto& messages = *static_cast<Messages*>(user);
        if (messages.first.empty()) {
            std::array<char, 256> text{};
            std::vsnprintf(text.data(), text.size(), format, arguments);
            messages.first = text.data();
            std::replace(messages.first.begin(), messages.first.end(), '\n', ' ');
            while (!messages.first.empty() &&
                   (messages.first.back() == '.' || messages.first.back() == ' '))
                messages.first.pop_back();
        }
        return 1; // handled: nothing goes to standard error
    }
    static int drop(TIFF*, void*, const char*, const char*, va_list) { return 1; }
};

using Handle = std::unique_ptr<TIFF, void (*)(TIFF*)>;

/// @param messages  must outlive the handle
Handle opened(const std::filesystem::path& path, std::uint64_t memoryLimit, Messages& messages)
{
    const std::unique_ptr<TIFFOpenOptions, void (*)(TIFFOpenOptions*)> options(
        TIFFOpenOptionsAlloc(), TIFFOpenOptionsFree);
    constexpr std::uint64_t kLeast = std::uint64_t{1} << 20U; // for directories
    TIFFOpenOptionsSetMaxSingleMemAlloc(
        options.get(),
        static_cast<tmsize_t>(std::clamp<std::uint64_t>(memoryLimit, kLeast, INT64_MAX)));
    TIFFOpenOptionsSetErrorHandlerExtR(options.get(), Messages::keep, &messages);
    TIFFOpenOptionsSetWarningHandlerExtR(options.get(), Messages::drop, nullptr);
    // 'm': not mapped, because a file cut short while it is mapped ends the program
    return {TIFFOpenExt(path.c_str(), "rm", options.get()), TIFFClose};
}

/// The numbers of a tag that libtiff doesn't know by itself, if they are of this type.
template <typename T>
std::vector<T> numbersOf(TIFF* tiff, std::uint32_t tag, TIFFDataType type)
{
    const TIFFField* field = TIFFFindField(tiff, tag, TIFF_ANY);
    std::uint32_t count = 0;
    const T* data = nullptr;
    if (field == nullptr || TIFFFieldDataType(field) != type || TIFFFieldPassCount(field) == 0 ||
        TIFFFieldReadCount(field) != TIFF_VARIABLE2 ||
        TIFFGetField(tiff, tag, &count, &data) == 0 || data == nullptr)
        return {};
    return {data, data + count};
}

GeoTags geoTagsOf(TIFF* tiff)
{
    GeoTags tags;
    tags.pixelScale = numbersOf<double>(tiff, kPixelScaleTag, TIFF_DOUBLE);
    tags.tiepoints = numbersOf<double>(tiff, kTiepointTag, TIFF_DOUBLE);
    tags.transformation = numbersOf<double>(tiff, kTransformationTag, TIFF_DOUBLE);
    tags.keys = numbersOf<std::uint16_t>(tiff, kGeoKeysTag, TIFF_SHORT);
    const std::vector<char> text = numbersOf<char>(tiff, kNoDataTag, TIFF_ASCII);
    tags.noData.assign(text.begin(), std::find(text.begin(), text.end(), '\0'));
    return tags;
}

std::optional<SampleType> typeOf(std::uint16_t format, std::uint16_t bits)
{
    switch (format) {
    case SAMPLEFORMAT_UINT:
    case SAMPLEFORMAT_VOID:
        return bits == 8    ? std::optional(SampleType::uint8)
               : bits == 16 ? std::optional(SampleType::uint16)
               : bits == 32 ? std::optional(SampleType::uint32)
               : bits == 64 ? std::optional(SampleType::uint64)
                            : std::nullopt;
    case SAMPLEFORMAT_INT:
        return bits == 8    ? std::optional(SampleType::int8)
               : bits == 16 ? std::optional(SampleType::int16)
               : bits == 32 ? std::optional(SampleType::int32)
               : bits == 64 ? std::optional(SampleType::int64)
                            : std::nullopt;
    case SAMPLEFORMAT_IEEEFP:
        return bits == 32   ? std::optional(SampleType::float32)
               : bits == 64 ? std::optional(SampleType::float64)
                            : std::nullopt;
    default:
        return std::nullopt;
    }
}

/// How many bytes one packed byte can become at most; 0 where nothing is known.
std::uint64_t mostExpansion(std::uint16_t compression)
{
    switch (compression) {
    case COMPRESSION_NONE:
        return 1;
    case COMPRESSION_PACKBITS:
        return 64;
    case COMPRESSION_DEFLATE:
    case COMPRESSION_ADOBE_DEFLATE:
        return 1032;
    case COMPRESSION_LZW:
        return 4096;
    default:
        return 0;
    }
}

/// The page that the handle stands on.
core::Result<TiffPage> pageOf(TIFF* tiff, std::uint64_t fileBytes, std::uint64_t memoryLimit)
{
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEWIDTH, &width) == 0 ||
        TIFFGetField(tiff, TIFFTAG_IMAGELENGTH, &height) == 0 || width == 0 || height == 0)
        return failure(
            ErrorCode::badData, "a page has no size; the file is damaged or was never finished");
    const std::string size = std::to_string(width) + " x " + std::to_string(height);
    if (width > kMostPixels || height > kMostPixels)
        return failure(
            ErrorCode::badData,
            "the header gives a size of " + size + " pixels; at most 2^30 a side are supported");
    std::uint16_t samples = 1;
    std::uint16_t bits = 1;
    std::uint16_t format = SAMPLEFORMAT_UINT;
    std::uint16_t photometric = PHOTOMETRIC_MINISBLACK;
    std::uint16_t compression = COMPRESSION_NONE;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLESPERPIXEL, &samples);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_BITSPERSAMPLE, &bits);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SAMPLEFORMAT, &format);
    TIFFGetField(tiff, TIFFTAG_PHOTOMETRIC, &photometric);
    TIFFGetFieldDefaulted(tiff, TIFFTAG_COMPRESSION, &compression);
    if (samples != 1 || photometric == PHOTOMETRIC_PALETTE)
        return failure(
            ErrorCode::badData,
            photometric == PHOTOMETRIC_PALETTE
                ? std::string("its pixels are numbers of a palette; convert them to grey")
                : "it has " + std::to_string(samples) +
                      " samples a pixel; write one band to a file of its own");
    const auto type = typeOf(format, bits);
    if (!type)
        return failure(
            ErrorCode::badData,
            "samples of " + std::to_string(bits) + " bits and format " + std::to_string(format) +
                " can't be read; convert them to integers of 8 to 64 bits, float or double");

    TiffPage page;
    page.width = static_cast<int>(width);
    page.height = static_cast<int>(height);
    page.type = *type;
    page.whiteIsZero = photometric == PHOTOMETRIC_MINISWHITE;
    page.directory = TIFFCurrentDirOffset(tiff);
    const std::uint64_t expansion = mostExpansion(compression);
    if (expansion > 0 && page.bytes() / expansion > fileBytes)
        return failure(
            ErrorCode::badData,
            "the header promises " + size + " pixels of " + std::to_string(bytesOf(*type)) +
                " bytes, but the file has only " + std::to_string(fileBytes) +
                " bytes; it is cut short, or its header is wrong");
    if (page.bytes() > memoryLimit)
        return failure(
            ErrorCode::resourceLimit,
            size + " pixels take " + std::to_string(page.bytes()) +
                " bytes, more than the memory limit of " + std::to_string(memoryLimit) +
                "; raise the limit or reduce the picture");

    const char* text = nullptr;
    if (TIFFGetField(tiff, TIFFTAG_IMAGEDESCRIPTION, &text) != 0 && text != nullptr)
        page.description = text;
    float resolution = 0;
    if (TIFFGetField(tiff, TIFFTAG_XRESOLUTION, &resolution) != 0)
        page.xResolution = double{resolution};
    if (TIFFGetField(tiff, TIFFTAG_YRESOLUTION, &resolution) != 0)
        page.yResolution = double{resolution};
    std::uint16_t unit = RESUNIT_INCH;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_RESOLUTIONUNIT, &unit);
    page.resolutionUnit = unit;
    page.geo = geoTagsOf(tiff);
    return page;
}

/// A copy of another page at a lower resolution, or a mask.
bool isSecondary(TIFF* tiff)
{
    std::uint32_t kind = 0;
    TIFFGetFieldDefaulted(tiff, TIFFTAG_SUBFILETYPE, &kind);
    return (kind & (FILETYPE_REDUCEDIMAGE | FILETYPE_MASK)) != 0;
}

tl::unexpected<core::Error> damaged(const Messages& messages)
{
    return failure(
        ErrorCode::badData,
        "the file can't be read as TIFF (" +
            (messages.first.empty() ? std::string("damaged data") : messages.first) +
            "); get it again");
}

bool readTiles(TIFF* tiff, const TiffPage& page, std::byte* into, std::uint64_t memoryLimit)
{
    std::uint32_t tileWidth = 0;
    std::uint32_t tileHeight = 0;
    if (TIFFGetField(tiff, TIFFTAG_TILEWIDTH, &tileWidth) == 0 ||
        TIFFGetField(tiff, TIFFTAG_TILELENGTH, &tileHeight) == 0 || tileWidth == 0 ||
        tileHeight == 0)
        return false;
    const std::size_t sample = bytesOf(page.type);
    const auto tileBytes = static_cast<std::uint64_t>(TIFFTileSize64(tiff));
    const auto width = static_cast<std::uint32_t>(page.width);
    const auto height = static_cast<std::uint32_t>(page.height);
    if (tileBytes != std::uint64_t{tileWidth} * tileHeight * sample ||
        tileBytes > std::max(memoryLimit, std::uint64_t{1} << 20U))
        return false;
    std::vector<std::byte> tile(tileBytes);
    for (std::uint32_t y = 0; y < height; y += tileHeight) {
        for (std::uint32_t x = 0; x < width; x += tileWidth) {
            if (TIFFReadTile(tiff, tile.data(), x, y, 0, 0) < 0)
                return false;
            const std::size_t columns = std::min(tileWidth, width - x);
            const std::uint32_t rows = std::min(tileHeight, height - y);
            for (std::uint32_t row = 0; row < rows; ++row)
                std::memcpy(
                    into + (std::size_t{y + row} * width + x) * sample,
                    tile.data() + std::size_t{row} * tileWidth * sample,
                    columns * sample);
        }
    }
    return true;
}

bool readStrips(TIFF* tiff, const TiffPage& page, std::byte* into)
{
    const std::size_t rowBytes = static_cast<std::size_t>(page.width) * bytesOf(page.type);
    if (static_cast<std::size_t>(TIFFScanlineSize64(tiff)) != rowBytes)
        return false;
    for (int row = 0; row < page.height; ++row)
        if (TIFFReadScanline(
                tiff,
                into + static_cast<std::size_t>(row) * rowBytes,
                static_cast<std::uint32_t>(row),
                0) < 0)
            return false;
    return true;
}

} // namespace

std::optional<std::uint16_t> GeoTags::key(std::uint16_t id) const
{
    // Four numbers of header, then four for each key: id, where it is (0: here), count, value.
    for (std::size_t at = 4; at + 3 < keys.size(); at += 4)
        if (keys[at] == id && keys[at + 1] == 0)
            return keys[at + 3];
    return std::nullopt;
}

core::Result<TiffFile> TiffFile::open(const std::filesystem::path& path, std::uint64_t memoryLimit)
{
    if (const auto readable = checkReadable(path); !readable)
        return tl::unexpected(readable.error());
    std::error_code failed;
    const std::uint64_t fileBytes = std::filesystem::file_size(path, failed);
    Messages messages;
    const Handle tiff = opened(path, memoryLimit, messages);
    if (!tiff)
        return damaged(messages);
    TiffFile file;
    file._path = path;
    file._memoryLimit = memoryLimit;
    do {
        if (isSecondary(tiff.get()))
            continue;
        auto page = pageOf(tiff.get(), fileBytes, memoryLimit);
        if (!page)
            return tl::unexpected(page.error());
        file._pages.push_back(std::move(*page));
        if (file._pages.size() > kMostPages)
            return failure(
                ErrorCode::badData,
                "it has more than " + std::to_string(kMostPages) + " pages; split the file");
    } while (TIFFReadDirectory(tiff.get()) != 0);
    if (file._pages.empty() || !messages.first.empty())
        return damaged(messages);
    return file;
}

core::Result<void> TiffFile::read(std::size_t page, std::span<std::byte> into) const
{
    const TiffPage& wanted = _pages.at(page);
    ISOFRONT_ASSERT(into.size() == wanted.bytes(), "the buffer must have the page's size");
    Messages messages;
    const Handle tiff = opened(_path, _memoryLimit, messages);
    if (!tiff || TIFFSetSubDirectory(tiff.get(), wanted.directory) == 0)
        return damaged(messages);
    // The file may have changed since it was opened.
    std::uint32_t width = 0;
    std::uint32_t height = 0;
    TIFFGetField(tiff.get(), TIFFTAG_IMAGEWIDTH, &width);
    TIFFGetField(tiff.get(), TIFFTAG_IMAGELENGTH, &height);
    if (width != static_cast<std::uint32_t>(wanted.width) ||
        height != static_cast<std::uint32_t>(wanted.height))
        return damaged(messages);
    const bool isRead = TIFFIsTiled(tiff.get()) != 0
                            ? readTiles(tiff.get(), wanted, into.data(), _memoryLimit)
                            : readStrips(tiff.get(), wanted, into.data());
    if (!isRead || !messages.first.empty())
        return damaged(messages);
    return {};
}

} // namespace isofront::raster
