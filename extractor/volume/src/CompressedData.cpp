#include "FileHeader.h"

#include <zlib.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace isofront::volume {

namespace {

/// How many bytes a zlib stream, or gzip members one after the other, unpack to, as far as they are
/// whole. Stops beyond `most`.
/// @param packedBytes  what may be read of the file
std::uint64_t inflatedBytes(std::istream& file, std::uint64_t packedBytes, std::uint64_t most)
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
        inflater.next_out = unpacked.data();
        inflater.avail_out = static_cast<uInt>(kChunk);
        state = inflate(&inflater, Z_NO_FLUSH);
        total += kChunk - inflater.avail_out;
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

} // namespace isofront::volume
