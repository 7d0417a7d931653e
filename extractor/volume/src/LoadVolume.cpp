#include "isofront/volume/LoadVolume.h"

#include "Assembly.h"
#include "DenseVoxels.h"
#include "DicomVolume.h"
#include "FileHeader.h"
#include "NiftiVolume.h"
#include "RawVolume.h"
#include "TextHeader.h"
#include "TiffVolume.h"
#include "ValueStatistics.h"
#include "VdbHeader.h"
#include "isofront/volume/VolumeField.h"

#include <isofront/raster/FileBytes.h>
#include <isofront/raster/TiffFile.h>

#include <glm/geometric.hpp>

#ifdef ISOFRONT_WITH_ITK
#include "ItkReader.h"
#endif
#ifdef ISOFRONT_WITH_OPENVDB
#include "VdbReader.h"
#endif

#include <cmath>
#include <exception>
#include <limits>
#include <new>
#include <optional>
#include <span>
#include <system_error>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

std::optional<VolumeFormat> formatOf(const std::filesystem::path& path)
{
    const std::string name = lowered(path.filename().string());
    if (name.ends_with(".nrrd") || name.ends_with(".nhdr"))
        return VolumeFormat::nrrd;
    if (name.ends_with(".nii") || name.ends_with(".nii.gz"))
        return VolumeFormat::nifti;
    if (name.ends_with(".mha") || name.ends_with(".mhd"))
        return VolumeFormat::metaImage;
    if (name.ends_with(".vdb"))
        return VolumeFormat::vdb;
    if (name.ends_with(".tif") || name.ends_with(".tiff"))
        return VolumeFormat::tiff;
    if (name.ends_with(".raw") || name.ends_with(".raw.gz") || name.ends_with(".bin"))
        return VolumeFormat::raw;
    return std::nullopt;
}

/// A folder with a TIFF file in it holds TIFF slices, any other DICOM.
VolumeFormat formatOfFolder(const std::filesystem::path& folder)
{
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file() && formatOf(entry.path()) == VolumeFormat::tiff)
            return VolumeFormat::tiff;
    return VolumeFormat::dicom;
}

[[maybe_unused]] tl::unexpected<core::Error> notBuiltIn(VolumeFormat format, const char* option)
{
    return failure(
        ErrorCode::usage,
        "this build can't read " + std::string(nameOf(format)) + " files; configure it with -D" +
            option + "=ON");
}

core::Result<LoadedVolume>
denseVolume(DenseVoxels dense, VolumeFormat format, const LoadOptions& options)
{
    if (options.voxelSize) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double length = glm::length(dense.worldFromIndex.linear[axis]);
            dense.worldFromIndex.linear[axis] *= (*options.voxelSize)[axis] / length;
        }
    }
    LoadedVolume volume;
    volume.info.notes = std::move(dense.notes);
    const core::Box box{glm::dvec3(0.0), glm::dvec3(dense.dimensions - 1)};
    if (const auto placed = placeVolume(volume, dense.worldFromIndex, box); !placed)
        return tl::unexpected(placed.error());
    VolumeInfo& info = volume.info;
    info.format = format;
    info.voxelType = static_cast<VoxelType>(dense.voxels.index());
    info.orientation = "The values are as in the file: solid is where they are at or above the "
                       "isovalue.";

    return std::visit(
        [&](const auto& voxels) -> core::Result<LoadedVolume> {
            using Value = typename std::remove_cvref_t<decltype(voxels)>::element_type;
            const std::size_t count = static_cast<std::size_t>(info.dimensions.x) *
                                      static_cast<std::size_t>(info.dimensions.y) *
                                      static_cast<std::size_t>(info.dimensions.z);
            info.values = summarised([&](auto&& visit) {
                for (const Value value : std::span<const Value>(voxels.get(), count))
                    visit(static_cast<double>(value), 1);
            });
            if (const auto finite = checkFinite(info.values); !finite)
                return tl::unexpected(finite.error());
            if (const auto stopped = checkStop(options); !stopped)
                return tl::unexpected(stopped.error());
            info.suggestedIsovalue = otsuThreshold(info.values);
            auto field = std::make_shared<const VolumeField<Value>>(info.dimensions, voxels);
            info.memoryBytes = field->memoryBytes();
            volume.field = std::move(field);
            return std::move(volume);
        },
        dense.voxels);
}

/// NRRD and MetaImage: our own code checks what the library will believe.
core::Result<DenseVoxels>
readChecked(const std::filesystem::path& path, VolumeFormat format, const LoadOptions& options)
{
    const auto header =
        format == VolumeFormat::nrrd ? readNrrdHeader(path) : readMetaImageHeader(path);
    if (!header)
        return tl::unexpected(header.error());
    if (const auto checked = checkHeader(*header, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    if (format != VolumeFormat::nrrd) {
        if (const auto checked = checkCompressedData(*header); !checked)
            return tl::unexpected(checked.error());
    }
#ifdef ISOFRONT_WITH_ITK
    auto voxels = readThroughItk(path, format, *header, options);
    // Teem counts bytes in its own words; ours say what to make of it.
    if (!voxels && voxels.error().code == ErrorCode::badData && !header->dataFile.empty())
        if (const auto checked = checkCompressedData(*header); !checked)
            return tl::unexpected(checked.error());
    return voxels;
#else
    return notBuiltIn(format, "ISOFRONT_WITH_ITK");
#endif
}

core::Result<DenseVoxels>
readDense(const std::filesystem::path& path, VolumeFormat format, const LoadOptions& options)
{
    switch (format) {
    case VolumeFormat::nifti:
        return readNiftiVolume(path, options);
    case VolumeFormat::tiff:
        return readTiffVolume(path, options);
    case VolumeFormat::raw:
        return readRawVolume(path, options);
    case VolumeFormat::dicom:
        return readDicomFolder(path, options);
    default:
        return readChecked(path, format, options);
    }
}

core::Result<LoadedVolume>
loadDense(const std::filesystem::path& path, VolumeFormat format, const LoadOptions& options)
{
    if (options.voxelSize) {
        const glm::dvec3& size = *options.voxelSize;
        if (!(size.x > 0 && size.y > 0 && size.z > 0 && std::isfinite(size.x + size.y + size.z)))
            return failure(ErrorCode::usage, "--voxel-size must be three numbers above 0");
    }
    auto dense = readDense(path, format, options);
    if (!dense)
        return tl::unexpected(dense.error());
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());
    return denseVolume(std::move(*dense), format, options);
}

core::Result<LoadedVolume>
loadSparse(const std::filesystem::path& path, [[maybe_unused]] const LoadOptions& options)
{
    const auto grids = readVdbHeader(path);
    if (!grids)
        return tl::unexpected(grids.error());
#ifdef ISOFRONT_WITH_OPENVDB
    return readThroughOpenVdb(path, *grids, options);
#else
    return notBuiltIn(VolumeFormat::vdb, "ISOFRONT_WITH_OPENVDB");
#endif
}

core::Result<LoadedVolume> load(const std::filesystem::path& path, const LoadOptions& options)
{
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());
    if (std::filesystem::is_directory(path))
        return loadDense(path, formatOfFolder(path), options);
    const auto format = formatOf(path);
    if (!format)
        return failure(
            ErrorCode::usage,
            "the extension is not one of a volume; supported are .nrrd, .nhdr, .nii, .nii.gz, "
            ".mha, .mhd, .vdb, .tif, .raw, .raw.gz, and folders of DICOM or TIFF slices");
    if (const auto readable = raster::checkReadable(path); !readable)
        return tl::unexpected(readable.error());
    return *format == VolumeFormat::vdb ? loadSparse(path, options)
                                        : loadDense(path, *format, options);
}

} // namespace

double fieldIsovalue(const LoadedVolume& volume, double userIsovalue)
{
    return volume.negated ? -userIsovalue : userIsovalue;
}

bool isVolume(const std::filesystem::path& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return true;
    const auto format = formatOf(path);
    if (format != VolumeFormat::tiff)
        return format.has_value();
    const auto file = raster::TiffFile::open(path, std::numeric_limits<std::uint64_t>::max());
    return file && file->pages().size() > 1;
}

core::Result<LoadedVolume> loadVolume(const std::filesystem::path& path, const LoadOptions& options)
{
    const auto failed = [&](ErrorCode code, const std::string& reason) {
        return failure(code, path.string() + ": " + reason);
    };
    try {
        return load(path, options).map_error([&](const core::Error& error) {
            return error.within(path.string());
        });
    } catch (const std::bad_alloc&) {
        return failed(ErrorCode::resourceLimit, "the volume doesn't fit in memory; reduce it");
    } catch (const std::exception& exception) {
        return failed(
            ErrorCode::badData, std::string("the file can't be read: ") + exception.what());
    }
}

} // namespace isofront::volume
