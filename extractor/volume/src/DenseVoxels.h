#pragma once

#include "isofront/volume/LoadVolume.h"

#include <isofront/raster/SampleType.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace isofront::volume {

/// Voxels in the type of their file; the alternatives stand in the order of VoxelType.
using VoxelArray = std::variant<
    std::shared_ptr<std::int8_t[]>,
    std::shared_ptr<std::uint8_t[]>,
    std::shared_ptr<std::int16_t[]>,
    std::shared_ptr<std::uint16_t[]>,
    std::shared_ptr<std::int32_t[]>,
    std::shared_ptr<std::uint32_t[]>,
    std::shared_ptr<float[]>,
    std::shared_ptr<double[]>>;

/// What a reader of dense volumes hands over.
struct DenseVoxels {
    glm::ivec3 dimensions{0};
    VoxelArray voxels;
    core::Affine worldFromIndex;    ///< LPS for medical formats
    std::vector<std::string> notes; ///< sentences about choices made for the user
};

/// Room for so many voxels, with no values yet.
VoxelArray allocatedVoxels(VoxelType type, std::size_t count);

/// Voxels of 64-bit integers in a type that is kept: in 32 bits where all fit, otherwise as
/// doubles. Adds a note that says which, and whether every value is exact.
VoxelArray narrowed(const std::int64_t* values, std::size_t count, std::vector<std::string>& notes);
VoxelArray
narrowed(const std::uint64_t* values, std::size_t count, std::vector<std::string>& notes);

/// Takes samples of any type, in this machine's byte order, as voxels. Samples of 64-bit integers
/// are narrowed; others are read straight to where they stay.
/// @param read  called once with where the samples go; what it says is passed on
template <typename Read>
core::Result<VoxelArray> readVoxels(
    raster::SampleType type, std::size_t count, std::vector<std::string>& notes, const Read& read)
{
    return raster::dispatched(type, [&](auto zero) -> core::Result<VoxelArray> {
        using T = decltype(zero);
        auto values = std::make_shared_for_overwrite<T[]>(count);
        const core::Result<void> done =
            read(std::as_writable_bytes(std::span<T>(values.get(), count)));
        if (!done)
            return tl::unexpected(done.error());
        if constexpr (std::is_integral_v<T> && sizeof(T) == 8)
            return narrowed(values.get(), count, notes);
        else
            return VoxelArray(std::move(values));
    });
}

} // namespace isofront::volume
