#pragma once

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace isofront::tests {

// Files as strings of bytes, written apart from the product's readers and from the libraries that
// they use.

/// The bytes of numbers, in either byte order.
template <typename T>
std::string bytesOf(const std::vector<T>& values, bool bigEndian = false)
{
    std::string bytes(values.size() * sizeof(T), '\0');
    if (!values.empty())
        std::memcpy(bytes.data(), values.data(), bytes.size());
    if (bigEndian)
        for (std::size_t i = 0; i < bytes.size(); i += sizeof(T))
            std::reverse(
                bytes.begin() + static_cast<std::ptrdiff_t>(i),
                bytes.begin() + static_cast<std::ptrdiff_t>(i + sizeof(T)));
    return bytes;
}

/// Packed by zlib: 15 bits of window for a zlib stream, 31 for a gzip file.
inline std::string deflated(const std::string& bytes, int windowBits = 15)
{
    z_stream stream{};
    deflateInit2(&stream, 6, Z_DEFLATED, windowBits, 8, Z_DEFAULT_STRATEGY);
    std::string packed(bytes.size() + bytes.size() / 100 + 1024, '\0');
    std::string source = bytes;
    stream.next_in = reinterpret_cast<Bytef*>(source.data());
    stream.avail_in = static_cast<uInt>(source.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    deflate(&stream, Z_FINISH);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

inline std::string gzipped(const std::string& bytes)
{
    return deflated(bytes, 31);
}

/// A page of a TIFF file. Its samples come as chunks, strips or tiles, in the file's byte order and
/// packed as `compression` says.
struct TiffPageBytes {
    std::uint32_t width = 1;
    std::uint32_t height = 1;
    std::uint16_t bits = 8;
    std::uint16_t format = 1; ///< 1 unsigned, 2 signed, 3 float
    std::vector<std::string> chunks;
    std::uint32_t rowsPerStrip = UINT32_MAX;
    std::uint32_t tileWidth = 0; ///< 0: strips
    std::uint32_t tileHeight = 0;
    std::uint16_t compression = 1;
    std::uint16_t samplesPerPixel = 1;
    std::uint16_t photometric = 1;
    std::uint32_t subfileType = 0;
    std::vector<std::pair<std::uint16_t, std::vector<double>>> doubles;
    std::vector<std::pair<std::uint16_t, std::vector<std::uint16_t>>> shorts;
    std::vector<std::pair<std::uint16_t, std::string>> texts;
};

/// A classic TIFF file.
inline std::string tiffBytes(const std::vector<TiffPageBytes>& pages, bool bigEndian = false)
{
    std::string file = bigEndian ? std::string("MM\0\x2a", 4) : std::string("II\x2a\0", 4);
    const auto put = [&](std::size_t at, auto value) {
        const std::string bytes = bytesOf(std::vector{value}, bigEndian);
        file.replace(at, bytes.size(), bytes);
    };
    file += std::string(4, '\0');
    std::size_t link = 4; // where the place of the next directory is to be written
    for (const TiffPageBytes& page : pages) {
        struct Entry {
            std::uint16_t tag, type;
            std::uint32_t count;
            std::string data;
        };
        std::vector<Entry> entries;
        const auto shorts = [&](std::uint16_t tag, const std::vector<std::uint16_t>& values) {
            entries.push_back(
                {tag, 3, static_cast<std::uint32_t>(values.size()), bytesOf(values, bigEndian)});
        };
        const auto longs = [&](std::uint16_t tag, const std::vector<std::uint32_t>& values) {
            entries.push_back(
                {tag, 4, static_cast<std::uint32_t>(values.size()), bytesOf(values, bigEndian)});
        };
        std::vector<std::uint32_t> offsets;
        std::vector<std::uint32_t> counts;
        for (const std::string& chunk : page.chunks) {
            offsets.push_back(static_cast<std::uint32_t>(file.size()));
            counts.push_back(static_cast<std::uint32_t>(chunk.size()));
            file += chunk;
            file += std::string(file.size() % 2, '\0');
        }
        if (page.subfileType != 0)
            longs(254, {page.subfileType});
        longs(256, {page.width});
        longs(257, {page.height});
        shorts(258, std::vector(page.samplesPerPixel, page.bits));
        shorts(259, {page.compression});
        shorts(262, {page.photometric});
        shorts(277, {page.samplesPerPixel});
        shorts(339, std::vector(page.samplesPerPixel, page.format));
        if (page.tileWidth > 0) {
            longs(322, {page.tileWidth});
            longs(323, {page.tileHeight});
            longs(324, offsets);
            longs(325, counts);
        } else {
            longs(273, offsets);
            longs(278, {page.rowsPerStrip});
            longs(279, counts);
        }
        for (const auto& [tag, values] : page.doubles)
            entries.push_back(
                {tag, 12, static_cast<std::uint32_t>(values.size()), bytesOf(values, bigEndian)});
        for (const auto& [tag, values] : page.shorts)
            shorts(tag, values);
        for (const auto& [tag, text] : page.texts)
            entries.push_back({tag, 2, static_cast<std::uint32_t>(text.size() + 1), text + '\0'});
        std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
            return a.tag < b.tag;
        });

        for (Entry& entry : entries)
            if (entry.data.size() > 4) {
                const auto at = static_cast<std::uint32_t>(file.size());
                file += entry.data;
                file += std::string(file.size() % 2, '\0');
                entry.data = bytesOf(std::vector{at}, bigEndian);
            } else {
                entry.data.resize(4, '\0');
            }
        put(link, static_cast<std::uint32_t>(file.size()));
        file += bytesOf(std::vector{static_cast<std::uint16_t>(entries.size())}, bigEndian);
        for (const Entry& entry : entries)
            file += bytesOf(std::vector{entry.tag, entry.type}, bigEndian) +
                    bytesOf(std::vector{entry.count}, bigEndian) + entry.data;
        link = file.size();
        file += std::string(4, '\0');
    }
    return file;
}

/// A grey PNG. Values are 16 bits if `bits` is 16, otherwise one byte each is packed to `bits`.
inline std::string greyPngBytes(
    std::uint32_t width,
    std::uint32_t height,
    const std::vector<std::uint16_t>& values,
    std::uint8_t bits = 16,
    std::uint8_t colour = 0)
{
    const auto chunk = [](const std::string& kind, const std::string& data) {
        const std::string body = kind + data;
        const auto check = static_cast<std::uint32_t>(
            crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size())));
        return bytesOf(std::vector{static_cast<std::uint32_t>(data.size())}, true) + body +
               bytesOf(std::vector{check}, true);
    };
    std::string rows;
    for (std::uint32_t y = 0; y < height; ++y) {
        rows += '\0'; // no filter
        for (std::uint32_t x = 0; x < width; ++x) {
            const std::size_t at = std::size_t{y} * width + x;
            const std::uint16_t value = at < values.size() ? values[at] : std::uint16_t{0};
            if (bits == 16)
                rows += static_cast<char>(value >> 8U);
            rows += static_cast<char>(value & 0xffU);
        }
    }
    return std::string("\x89PNG\r\n\x1a\n", 8) +
           chunk(
               "IHDR",
               bytesOf(std::vector{width, height}, true) + static_cast<char>(bits) +
                   static_cast<char>(colour) + std::string(3, '\0')) +
           chunk("IDAT", deflated(rows)) + chunk("IEND", "");
}

} // namespace isofront::tests
