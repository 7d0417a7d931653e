#include "FileHeader.h"

#include <algorithm>
#include <cmath>
#include <system_error>

namespace isofront::volume {

std::uint64_t FileHeader::dataBytes() const
{
    return static_cast<std::uint64_t>(dimensions[0]) * static_cast<std::uint64_t>(dimensions[1]) *
           static_cast<std::uint64_t>(dimensions[2]) * voxelBytes;
}

core::Result<void> checkHeader(const FileHeader& header, std::uint64_t memoryLimit)
{
    using core::ErrorCode;
    // An index must fit an int, and half of its range leaves room for steps outside.
    constexpr std::int64_t kMostVoxels = std::int64_t{1} << 30U;
    std::string size;
    for (const std::int64_t voxels : header.dimensions)
        size += (size.empty() ? "" : " x ") + std::to_string(voxels);
    for (const std::int64_t voxels : header.dimensions) {
        if (voxels < 1)
            return core::failure(
                ErrorCode::badData,
                "the header gives a size of " + size +
                    " voxels; a volume has at least one along each axis");
        if (voxels > kMostVoxels)
            return core::failure(
                ErrorCode::badData,
                "the header gives a size of " + size +
                    " voxels; at most 2^30 along an axis are supported");
    }

    // In double, because the product can exceed 64 bits; a few roundings don't matter here.
    const double bytes =
        static_cast<double>(header.dimensions[0]) * static_cast<double>(header.dimensions[1]) *
        static_cast<double>(header.dimensions[2]) * static_cast<double>(header.voxelBytes);
    if (!header.dataFile.empty()) {
        std::error_code failed;
        const std::uintmax_t fileBytes = std::filesystem::file_size(header.dataFile, failed);
        if (failed)
            return core::failure(
                ErrorCode::inputOutput,
                "its data file " + header.dataFile.string() +
                    " can't be read: " + failed.message());
        const std::uintmax_t held =
            fileBytes - std::min<std::uintmax_t>(fileBytes, header.dataOffset);
        double most = static_cast<double>(held);
        switch (header.encoding) {
        case FileHeader::Encoding::raw:
            break;
        case FileHeader::Encoding::deflate:
            most *= 1032;
            break;                       // the format's best ratio
        case FileHeader::Encoding::text: // a digit and a blank a voxel, the last blank left out
            most = 0.5 * (most + 1) * static_cast<double>(header.voxelBytes);
            break;
        case FileHeader::Encoding::hex:
            most /= 2;
            break;
        case FileHeader::Encoding::other:
            most = bytes;
            break;
        }
        if (bytes > most)
            return core::failure(
                ErrorCode::badData,
                "the header promises " + size + " voxels of " + std::to_string(header.voxelBytes) +
                    " bytes, but the file has only " + std::to_string(held) +
                    " bytes of data; it is cut short, or its header is wrong");
    }
    if (bytes > static_cast<double>(memoryLimit))
        return core::failure(
            ErrorCode::resourceLimit,
            size + " voxels take " +
                std::to_string(std::llround(std::min(bytes / 1048576.0, 1e18))) +
                " MiB, which is above the limit of " + std::to_string(memoryLimit >> 20U) +
                " MiB; raise the limit or reduce the volume");
    return {};
}

} // namespace isofront::volume
