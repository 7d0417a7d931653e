#include "FileHeader.h"

#include <isofront/core/Assert.h>

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace isofront::volume {

namespace {

/// How many bytes a zlib stream, or gzip members one after the other, unpack to, as far as they are
/// whole. Stops beyond `most`.
/// @param packedBytes  what may be read of the file
/// @param into         room for `most` bytes, or null
std::uint64_t inflatedBytes(
    std::istream& file, std::uint64_t packedBytes, std::uint64_t most, std::byte* into = nullptr)
{
    constexpr std::size_t kChunk = std::size_t{1} << 18U;
    std::vector<unsigned char> packed(kChunk);
    std::vector<unsigned char> unpacked(kChunk);
    z_stream inflater{};
    constexpr int kZlibOrGzip = MAX_WBITS + 32;
    if (inflateInit2(&inflater, kZlibOrGzip) != Z_OK)
        return 0;
    std::uint64_t total = 0;
    for (int state = Z_OK; total < most && (state == Z_OK || state == Z_STREAM_END);) {
        if (inflater.avail_in == 0) {
            file.read(
                reinterpret_cast<char*>(packed.data()),
                static_cast<std::streamsize>(std::min<std::uint64_t>(kChunk, packedBytes)));
            inflater.next_in = packed.data();
            inflater.avail_in = static_cast<uInt>(file.gcount());
            if (inflater.avail_in == 0)
                break;
            packedBytes -= inflater.avail_in;
        }
        if (state == Z_STREAM_END && inflateReset(&inflater) != Z_OK)
            break;
        const std::uint64_t room =
            into != nullptr ? std::min<std::uint64_t>(kChunk, most - total) : kChunk;
        inflater.next_out =
            into != nullptr ? reinterpret_cast<Bytef*>(into + total) : unpacked.data();
        inflater.avail_out = static_cast<uInt>(room);
        state = inflate(&inflater, Z_NO_FLUSH);
        total += room - inflater.avail_out;
    }
    inflateEnd(&inflater);
    return total;
}

} // namespace

core::Result<void> checkCompressedData(const FileHeader& header)
{
    if (header.encoding != FileHeader::Encoding::deflate)
        return {};
    std::ifstream file(header.dataFile, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(header.dataOffset));
    const std::uint64_t packed =
        header.packedBytes > 0 ? header.packedBytes : std::numeric_limits<std::uint64_t>::max();
    const std::uint64_t needed = header.unpackedOffset + header.dataBytes();
    const std::uint64_t whole = inflatedBytes(file, packed, needed);
    if (whole < needed)
        return core::failure(
            core::ErrorCode::badData,
            "the compressed data are damaged or cut short: they unpack to " +
                std::to_string(whole) + " of " + std::to_string(needed) + " bytes");
    return {};
}

core::Result<void> readCompressedData(const FileHeader& header, std::span<std::byte> into)
{
    ISOFRONT_ASSERT(into.size() == header.dataBytes(), "the buffer must have the data's size");
    std::ifstream file(header.dataFile, std::ios::binary);
    file.seekg(static_cast<std::streamoff>(header.dataOffset));
    const std::uint64_t packed =
        header.packedBytes > 0 ? header.packedBytes : std::numeric_limits<std::uint64_t>::max();
    if (inflatedBytes(file, packed, into.size(), into.data()) < into.size())
        return core::failure(
            core::ErrorCode::badData, "the compressed data are damaged; get the file again");
    if (header.bigEndian != (std::endian::native == std::endian::big)) {
        const auto size = static_cast<std::ptrdiff_t>(header.voxelBytes);
        for (auto number = into.begin(); number != into.end(); number += size)
            std::reverse(number, number + size);
    }
    return {};
}

} // namespace isofront::volume
