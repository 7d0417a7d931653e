#pragma once

#include "FileHeader.h"
#include "isofront/volume/LoadVolume.h"

#include <glm/vec3.hpp>

#include <cstdint>
#include <memory>
#include <variant>

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

struct DenseVoxels {
    glm::ivec3 dimensions{0};
    VoxelArray voxels;
    core::Affine worldFromIndex; ///< LPS
};

/// Reads a dense volume through ITK. The header has passed `checkHeader`. May throw what ITK
/// throws. Thread: any; calls wait for each other.
core::Result<DenseVoxels>
readThroughItk(const std::filesystem::path& path, VolumeFormat format, const LoadOptions& options);

} // namespace isofront::volume
