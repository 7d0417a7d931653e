#include "FileHeader.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <fstream>
#include <memory>

// Source: nifti1.h, the official definition of the NIfTI-1 header (nifti.nimh.nih.gov).

namespace isofront::volume {

namespace {

using core::ErrorCode;

constexpr std::size_t kHeaderBytes = 348;

/// The header's numbers, in the byte order of the file.
class Bytes {
public:
    Bytes(const std::array<unsigned char, kHeaderBytes>& bytes, bool isSwapped)
        : _bytes(bytes), _isSwapped(isSwapped)
    {
    }

    template <typename T>
    [[nodiscard]] T at(std::size_t offset) const
    {
        std::array<unsigned char, sizeof(T)> raw{};
        std::copy_n(_bytes.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
        if (_isSwapped)
            std::reverse(raw.begin(), raw.end());
        return std::bit_cast<T>(raw);
    }

private:
    const std::array<unsigned char, kHeaderBytes>& _bytes;
    bool _isSwapped;
};

/// Bytes of a voxel of a scalar type that we keep; 0 for other types.
std::uint64_t bytesOfNiftiType(std::int16_t type)
{
    switch (type) {
    case 2:   // uint8
    case 256: // int8
        return 1;
    case 4:   // int16
    case 512: // uint16
        return 2;
    case 8:   // int32
    case 16:  // float
    case 768: // uint32
        return 4;
    case 64: // double
        return 8;
    default:
        return 0;
    }
}

} // namespace

core::Result<FileHeader> readNiftiHeader(const std::filesystem::path& path)
{
    std::array<unsigned char, kHeaderBytes> raw{};
    // zlib reads plain files as they are.
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file)
        return core::failure(ErrorCode::inputOutput, "the file can't be opened");
    if (gzread(file.get(), raw.data(), kHeaderBytes) != static_cast<int>(kHeaderBytes))
        return core::failure(
            ErrorCode::badData,
            "the file is damaged or too short for the 348 bytes of a NIfTI "
            "header");
    const bool isCompressed = gzdirect(file.get()) == 0;

    const Bytes native(raw, false);
    const Bytes swapped(raw, true);
    const bool isSwapped = swapped.at<std::int32_t>(0) == std::int32_t{kHeaderBytes};
    const Bytes& bytes = isSwapped ? swapped : native;
    if (bytes.at<std::int32_t>(0) != std::int32_t{kHeaderBytes} ||
        std::memcmp(raw.data() + 344, "n+1", 4) != 0)
        return core::failure(
            ErrorCode::badData,
            "the file has no NIfTI-1 header with its data in the same file; convert it to that");

    const auto axes = bytes.at<std::int16_t>(40);
    FileHeader header;
    header.dataFile = path;
    header.dimensions = {1, 1, 1};
    if (axes < 1 || axes > 7)
        return core::failure(
            ErrorCode::badData, "the NIfTI header counts " + std::to_string(axes) + " axes");
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(axes); ++axis) {
        const auto voxels = bytes.at<std::int16_t>(42 + 2 * axis);
        if (axis < 3)
            header.dimensions[axis] = voxels;
        else if (voxels > 1)
            return core::failure(
                ErrorCode::badData,
                "the file has more than three axes (times or components); "
                "extract one volume of it");
    }
    if (axes < 3)
        return core::failure(
            ErrorCode::badData,
            "the file has " + std::to_string(axes) + " axes; a volume has three");

    const auto type = bytes.at<std::int16_t>(70);
    header.voxelBytes = bytesOfNiftiType(type);
    if (header.voxelBytes == 0)
        return core::failure(
            ErrorCode::badData,
            "voxels of NIfTI type " + std::to_string(type) +
                " can't be read; convert them to one integer of at most 32 bits, float or double");
    const auto offset = bytes.at<float>(108);
    if (!(offset >= float{kHeaderBytes} && offset <= 2147483520.0F))
        return core::failure(
            ErrorCode::badData, "the NIfTI header places the voxels inside itself");
    header.encoding = isCompressed ? FileHeader::Encoding::deflate : FileHeader::Encoding::raw;
    (isCompressed ? header.unpackedOffset : header.dataOffset) = static_cast<std::uint64_t>(offset);
    return header;
}

} // namespace isofront::volume
