// Based on: nifti1.h and nifti2.h, the official definitions of both headers (nifti.nimh.nih.gov).

#include "NiftiVolume.h"

#include "FileHeader.h"
#include "RawNumbers.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <string>
#include <type_traits>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

constexpr std::int32_t kHeaderBytes1 = 348;
constexpr std::int32_t kHeaderBytes2 = 540;

/// A header's numbers, in the byte order of the file.
class Bytes {
public:
    std::array<unsigned char, kHeaderBytes2> raw{};
    bool isSwapped = false;

    template <typename T>
    [[nodiscard]] T at(std::size_t offset) const
    {
        std::array<unsigned char, sizeof(T)> bytes{};
        std::copy_n(raw.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), bytes.begin());
        if (isSwapped)
            std::reverse(bytes.begin(), bytes.end());
        return std::bit_cast<T>(bytes);
    }
};

/// What both versions say, in the types of the second.
struct Header {
    std::array<std::int64_t, 8> dim{}; ///< their number, then sizes
    std::int16_t type = 0;
    double offset = 0; ///< [bytes] of the voxels
    double slope = 0;
    double intercept = 0;
    std::array<double, 8> pixdim{}; ///< handedness of the qform, then voxel sizes
    std::int32_t qformCode = 0;
    std::int32_t sformCode = 0;
    std::array<double, 6> quaternion{}; ///< b, c, d, then the origin
    std::array<double, 12> sform{};     ///< by rows
};

template <typename Size, typename Real>
void readNumbers(
    const Bytes& bytes,
    Header& header,
    std::size_t dim,
    std::size_t pixdim,
    std::size_t quaternion,
    std::size_t sform)
{
    for (std::size_t i = 0; i < 8; ++i) {
        header.dim[i] = bytes.at<Size>(dim + i * sizeof(Size));
        header.pixdim[i] = double(bytes.at<Real>(pixdim + i * sizeof(Real)));
    }
    for (std::size_t i = 0; i < 6; ++i)
        header.quaternion[i] = double(bytes.at<Real>(quaternion + i * sizeof(Real)));
    for (std::size_t i = 0; i < 12; ++i)
        header.sform[i] = double(bytes.at<Real>(sform + i * sizeof(Real)));
}

std::optional<Header> headerFrom(Bytes& bytes, std::size_t held)
{
    if (held < kHeaderBytes1)
        return std::nullopt;
    Header header;
    for (const bool swapped : {false, true}) {
        bytes.isSwapped = swapped;
        const auto size = bytes.at<std::int32_t>(0);
        if (size == kHeaderBytes1 && std::memcmp(bytes.raw.data() + 344, "n+1", 4) == 0) {
            readNumbers<std::int16_t, float>(bytes, header, 40, 76, 256, 280);
            header.type = bytes.at<std::int16_t>(70);
            header.offset = double(bytes.at<float>(108));
            header.slope = double(bytes.at<float>(112));
            header.intercept = double(bytes.at<float>(116));
            header.qformCode = bytes.at<std::int16_t>(252);
            header.sformCode = bytes.at<std::int16_t>(254);
            return header;
        }
        if (size == kHeaderBytes2 && held >= kHeaderBytes2 &&
            std::memcmp(bytes.raw.data() + 4, "n+2\0\r\n\032\n", 8) == 0) {
            readNumbers<std::int64_t, double>(bytes, header, 16, 104, 352, 400);
            header.type = bytes.at<std::int16_t>(12);
            header.offset = double(bytes.at<std::int64_t>(168));
            header.slope = bytes.at<double>(176);
            header.intercept = bytes.at<double>(184);
            header.qformCode = bytes.at<std::int32_t>(344);
            header.sformCode = bytes.at<std::int32_t>(348);
            return header;
        }
    }
    return std::nullopt;
}

std::optional<raster::SampleType> sampleTypeOf(std::int16_t type)
{
    using raster::SampleType;
    switch (type) {
    case 2:
        return SampleType::uint8;
    case 4:
        return SampleType::int16;
    case 8:
        return SampleType::int32;
    case 16:
        return SampleType::float32;
    case 64:
        return SampleType::float64;
    case 256:
        return SampleType::int8;
    case 512:
        return SampleType::uint16;
    case 768:
        return SampleType::uint32;
    case 1024:
        return SampleType::int64;
    case 1280:
        return SampleType::uint64;
    default:
        return std::nullopt;
    }
}

/// The size and place of the voxels.
core::Result<FileHeader> layoutOf(const Header& header, std::size_t voxelBytes, bool isPacked)
{
    FileHeader layout;
    layout.dimensions = {1, 1, 1};
    const std::int64_t axes = header.dim[0];
    if (axes < 1 || axes > 7)
        return failure(
            ErrorCode::badData, "the NIfTI header counts " + std::to_string(axes) + " axes");
    if (axes < 3)
        return failure(
            ErrorCode::badData,
            "the file has " + std::to_string(axes) + " axes; a volume has three");
    for (std::size_t axis = 0; axis < static_cast<std::size_t>(axes); ++axis) {
        const std::int64_t voxels = header.dim[axis + 1];
        if (axis < 3)
            layout.dimensions[axis] = voxels;
        else if (voxels > 1)
            return failure(
                ErrorCode::badData,
                "the file has more than three axes (times or components); "
                "extract one volume of it");
    }
    layout.voxelBytes = voxelBytes;
    if (!(header.offset >= kHeaderBytes1 && header.offset <= 0x1p52))
        return failure(ErrorCode::badData, "the NIfTI header places the voxels inside itself");
    layout.encoding = isPacked ? FileHeader::Encoding::deflate : FileHeader::Encoding::raw;
    (isPacked ? layout.unpackedOffset : layout.dataOffset) =
        static_cast<std::uint64_t>(header.offset);
    return layout;
}

/// From voxel indices to RAS.
core::Affine rasFromIndex(const Header& header)
{
    core::Affine map;
    if (header.sformCode > 0) {
        for (std::size_t row = 0; row < 3; ++row) {
            for (std::size_t column = 0; column < 3; ++column)
                map.linear[column][row] = header.sform[4 * row + column];
            map.translation[row] = header.sform[4 * row + 3];
        }
        return map;
    }
    glm::dmat3 rotation(1.0);
    if (header.qformCode > 0) {
        double b = header.quaternion[0];
        double c = header.quaternion[1];
        double d = header.quaternion[2];
        const double square = b * b + c * c + d * d;
        double a = std::sqrt(std::max(1 - square, 0.0));
        if (square > 1) { // rounded: half a turn
            const double length = std::sqrt(square);
            b /= length;
            c /= length;
            d /= length;
            a = 0;
        }
        rotation = glm::dmat3(
            a * a + b * b - c * c - d * d,
            2 * (b * c + a * d),
            2 * (b * d - a * c),
            2 * (b * c - a * d),
            a * a + c * c - b * b - d * d,
            2 * (c * d + a * b),
            2 * (b * d + a * c),
            2 * (c * d - a * b),
            a * a + d * d - b * b - c * c);
        if (header.pixdim[0] < 0)
            rotation[2] = -rotation[2];
        map.translation = {header.quaternion[3], header.quaternion[4], header.quaternion[5]};
    }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double size = std::abs(header.pixdim[axis + 1]);
        map.linear[axis] = (size > 0 ? size : 1.0) * rotation[axis]; // NaN goes to 1
    }
    return map;
}

VoxelArray scaled(const VoxelArray& voxels, std::size_t count, double slope, double intercept)
{
    auto result = std::make_shared_for_overwrite<float[]>(count);
    std::visit(
        [&](const auto& values) {
            std::transform(values.get(), values.get() + count, result.get(), [&](auto value) {
                return static_cast<float>(static_cast<double>(value) * slope + intercept);
            });
        },
        voxels);
    return result;
}

} // namespace

core::Result<DenseVoxels>
readNiftiVolume(const std::filesystem::path& path, const LoadOptions& options)
{
    Bytes bytes;
    bool isPacked = false;
    int held = 0;
    {
        // zlib reads plain files as they are.
        const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
        if (!file)
            return failure(
                ErrorCode::inputOutput, "the file can't be opened; check its permissions");
        held = gzread(file.get(), bytes.raw.data(), kHeaderBytes2);
        isPacked = gzdirect(file.get()) == 0;
    }
    if (held < kHeaderBytes1)
        return failure(
            ErrorCode::badData,
            "the file is damaged or too short for the 348 bytes of a NIfTI header");
    const auto header = headerFrom(bytes, static_cast<std::size_t>(held));
    if (!header)
        return failure(
            ErrorCode::badData,
            "the file has no NIfTI header with its data in the same file; convert it to that");
    const auto type = sampleTypeOf(header->type);
    if (!type)
        return failure(
            ErrorCode::badData,
            "voxels of NIfTI type " + std::to_string(header->type) +
                " can't be read; convert them to one integer, float or double a voxel");
    auto layout = layoutOf(*header, raster::bytesOf(*type), isPacked);
    if (!layout)
        return tl::unexpected(layout.error());
    layout->dataFile = path;
    if (const auto checked = checkHeader(*layout, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());

    DenseVoxels dense;
    dense.dimensions =
        glm::ivec3(layout->dimensions[0], layout->dimensions[1], layout->dimensions[2]);
    core::Affine map = rasFromIndex(*header);
    for (std::size_t column = 0; column < 3; ++column) { // RAS to LPS
        map.linear[column].x = -map.linear[column].x;
        map.linear[column].y = -map.linear[column].y;
    }
    map.translation.x = -map.translation.x;
    map.translation.y = -map.translation.y;
    dense.worldFromIndex = map;
    const bool bigEndian = bytes.isSwapped != (std::endian::native == std::endian::big);
    auto voxels = readRawNumbers(*layout, *type, bigEndian, dense.notes);
    if (!voxels)
        return tl::unexpected(voxels.error());
    dense.voxels = std::move(*voxels);
    const double slope = header->slope;
    const double intercept = header->intercept;
    if (std::isfinite(slope) && std::isfinite(intercept) && slope != 0 &&
        (slope != 1 || intercept != 0)) {
        dense.voxels =
            scaled(dense.voxels, layout->dataBytes() / layout->voxelBytes, slope, intercept);
        dense.notes.push_back(
            "The file scales its values, by " + std::to_string(slope) + " and then " +
            std::to_string(intercept) + "; they are kept as floats.");
    }
    return dense;
}

} // namespace isofront::volume
