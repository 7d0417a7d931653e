#include "RawNumbers.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <span>
#include <string>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

/// Turns the bytes of every number round.
void swapBytes(std::span<std::byte> bytes, std::size_t size)
{
    for (std::size_t i = 0; i + size <= bytes.size(); i += size)
        std::reverse(
            bytes.begin() + static_cast<std::ptrdiff_t>(i),
            bytes.begin() + static_cast<std::ptrdiff_t>(i + size));
}

core::Result<void> readBytes(const FileHeader& header, std::span<std::byte> into)
{
    // zlib reads plain files as they are.
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(
        gzopen(header.dataFile.c_str(), "rb"), gzclose);
    if (!file)
        return failure(
            ErrorCode::inputOutput,
            "its data file " + header.dataFile.string() +
                " can't be opened; check its permissions");
    const bool isPacked = header.encoding == FileHeader::Encoding::deflate;
    const std::uint64_t offset = isPacked ? header.unpackedOffset : header.dataOffset;
    if (gzseek(file.get(), static_cast<z_off_t>(offset), SEEK_SET) < 0)
        return failure(ErrorCode::badData, "the data end before the voxels begin");
    constexpr std::size_t kMost = std::size_t{1} << 28U; // of a call
    std::size_t held = 0;
    while (held < into.size()) {
        const auto wanted = static_cast<unsigned>(std::min(kMost, into.size() - held));
        const int read = gzread(file.get(), into.data() + held, wanted);
        if (read > 0)
            held += static_cast<std::size_t>(read);
        if (read < static_cast<int>(wanted))
            break;
    }
    if (held < into.size())
        return failure(
            ErrorCode::badData,
            isPacked ? "the compressed data are damaged or cut short: they unpack to " +
                           std::to_string(offset + held) + " of " +
                           std::to_string(offset + into.size()) + " bytes"
                     : "the data are cut short: there are " + std::to_string(held) + " of " +
                           std::to_string(into.size()) + " bytes");
    return {};
}

} // namespace

core::Result<VoxelArray> readRawNumbers(
    const FileHeader& header,
    raster::SampleType type,
    bool bigEndian,
    std::vector<std::string>& notes)
{
    const std::size_t size = raster::bytesOf(type);
    return readVoxels(
        type,
        header.dataBytes() / size,
        notes,
        [&](std::span<std::byte> into) -> core::Result<void> {
            if (auto read = readBytes(header, into); !read)
                return read;
            if (bigEndian != (std::endian::native == std::endian::big))
                swapBytes(into, size);
            return {};
        });
}

} // namespace isofront::volume
