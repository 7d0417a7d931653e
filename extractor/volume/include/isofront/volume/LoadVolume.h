#pragma once

#include "isofront/volume/VolumeInfo.h"

#include <isofront/core/Affine.h>
#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

namespace isofront::volume {

struct LoadOptions {
    /// [bytes] A volume whose voxels take more is refused before they are allocated.
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U;
    /// VDB: the grid to read. Empty takes the first scalar grid of the file.
    std::string gridName = {};
    /// DICOM: part of the identifier or the description of the series to read. Empty takes the one
    /// with the most slices.
    std::string series = {};
    /// Raw: what is in the file, as "256x256x128,uint16,little,0": size, type, byte order, offset
    /// in bytes; the last two may be left out where they don't matter. Empty: a JSON file says it.
    std::string rawLayout = {};
    /// Of dense volumes: the distance of voxels along each axis, instead of what the file says.
    std::optional<glm::dvec3> voxelSize = {};
    /// Looked at between the steps of loading; a read in progress is not cut short.
    std::stop_token stop = {};
};

/// A volume from a file, as a field in index space with its place in the world.
struct LoadedVolume {
    std::shared_ptr<const fields::Field> field; ///< in index space, solid where >= isovalue
    /// From index space to the source's physical space, right-handed LPS (left, posterior,
    /// superior) for medical images as in ITK: what NIfTI and some NRRD files state in RAS has x
    /// and y negated.
    core::Affine worldFromIndex;
    core::Box dataBox; ///< [index] the box of voxel centres
    /// [index] Edge of the cubic domain that holds the data box: the least power of two of voxels
    /// that is at least max(dimensions) - 1, and at least 2.
    double domainEdge = 2;
    glm::dvec3 domainOrigin{0.0}; ///< [index] its low corner, on a voxel's centre
    VolumeInfo info;
    bool negated = false; ///< the field has the sign of the file's values turned
};

/// The isovalue that `volume.field` needs to show what the user calls `userIsovalue`.
/// @param userIsovalue  [units of the file's values]
double fieldIsovalue(const LoadedVolume& volume, double userIsovalue);

/// True if the path is a folder, or has the name of a volume. TIFF files have it only if they hold
/// several pages.
bool isVolume(const std::filesystem::path& path);

/// Reads a volume, by extension, upper or lower case: .nrrd .nhdr .mha .mhd (through ITK), .nii
/// .nii.gz, .tif .tiff with several pages, .raw .raw.gz .bin with a described header, .vdb (through
/// OpenVDB); and folders of TIFF slices or of DICOM slices, plain or as runs (RLE).
///
/// Dense volumes keep the voxel type of the file and its values. A NIfTI scale factor makes them
/// float; a DICOM slope and intercept too, unless whole numbers stay whole: then the smallest type
/// that holds all values is taken. Integers of 64 bits are
/// kept in 32 where all of them fit, otherwise as doubles, and a note says so. Non-finite voxels
/// are kept and counted.
///
/// TIFF: slices come in the order of the pages, or of the names, where slice2 comes before slice10.
/// Only ImageJ and OME files say how large a voxel is; for others `voxelSize` is needed. Rows run
/// along y as stored. DICOM: slices of a series, sorted by their place along their normal; missing
/// ones are an error, a tilted gantry gives a sheared map. Of a VDB, float and double grids with an
/// affine transform can be read; level sets are negated, so that solid is at or above the isovalue,
/// and their data box is that of the active voxels grown by one.
///
/// Errors: inputOutput for what can't be opened; usage for an unknown extension, grid or series,
/// for a size or layout that is not given, and for a format whose reader is not built in; badData
/// for what is no three-dimensional scalar volume, is damaged or cut short, or has no finite voxel;
/// resourceLimit for what exceeds the memory limit; interrupted after a stop was requested. Headers
/// are checked against the size of the file before memory is taken.
///
/// Thread: any; what is read through ITK is read one at a time, because the libraries below have
/// global state.
core::Result<LoadedVolume>
loadVolume(const std::filesystem::path& path, const LoadOptions& options = {});

} // namespace isofront::volume
