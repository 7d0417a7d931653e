#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::volume {

/// The types in which voxels are kept; each volume stays in the type of its file, but for integers
/// of 64 bits.
enum class VoxelType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

/// "int8", "uint8" ... "float32", "float64".
std::string_view nameOf(VoxelType type);
/// Bytes that one voxel of the type takes.
std::size_t bytesOf(VoxelType type);

enum class VolumeFormat { nrrd, nifti, metaImage, vdb, dicom, tiff, raw, mesh };

/// "NRRD", "NIfTI", "MetaImage", "OpenVDB", "DICOM", "TIFF", "raw" or "mesh".
std::string_view nameOf(VolumeFormat format);

/// How the finite values of a volume are distributed.
struct ValueSummary {
    static constexpr std::size_t kBins = 256;

    double low = 0;                ///< least finite value
    double high = 0;               ///< greatest finite value
    std::uint64_t finiteCount = 0; ///< voxels with a finite value
    std::uint64_t nonFiniteCount =
        0; ///< voxels that are NaN, infinite or beyond the range of float
    /// Voxels by value: kBins bins of equal width that divide [low, high], lowest first; the last
    /// one includes `high`. Everything is in the first bin where all values are equal.
    std::array<std::uint64_t, kBins> histogram{};
};

/// What a volume's file says about itself. Values are those of the file: nothing here is negated.
struct VolumeInfo {
    VolumeFormat format = VolumeFormat::nrrd;
    glm::ivec3 dimensions{0}; ///< voxels along the index axes; for VDB those of the data box
    VoxelType voxelType = VoxelType::uint8;
    /// [world] distance of neighbouring voxel centres along each index axis, > 0.
    glm::dvec3 spacing{1.0};
    /// [world] the centre of the voxel with index (0, 0, 0).
    glm::dvec3 origin{0.0};
    /// Column i is the unit vector in which index axis i runs in the world.
    glm::dmat3 direction{1.0};
    /// Over all voxels of a dense volume, over the active ones of a VDB grid.
    ValueSummary values;
    /// A value that separates the matter from the air: Otsu's threshold, 0 for a level set.
    double suggestedIsovalue = 0;
    /// What the field takes in memory: voxels and min/max tree.
    std::uint64_t memoryBytes = 0;
    std::string gridName;               ///< VDB: the grid that was read
    std::vector<std::string> gridNames; ///< VDB: all grids of the file, in its order
    std::string orientation;        ///< one sentence: what was done so that solid is >= isovalue
    std::vector<std::string> notes; ///< sentences about choices made for the user
};

} // namespace isofront::volume
