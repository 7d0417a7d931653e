#pragma once

#include "Arguments.h"
#include "ModelSource.h"

#include <isofront/core/Result.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace isofront::cli {

/// What `render` needs to know to draw a picture of a stored voxel model.
struct VoxelPictureRequest {
    std::filesystem::path model;
    std::string output;
    std::optional<glm::dvec3> eye{};
    std::optional<glm::dvec3> target{};
    std::optional<glm::dvec3> up{}; ///< not given: y, as most meshes have it; z for fields
    double fov = 45;                ///< [degrees]
    PictureSize size;
    double voxelPixels = 1; ///< largest voxel [px]
    std::string way = "auto";
    std::uint64_t cacheBytes = 0;                        ///< of the device, for chunks
    int samples = 1;                                     ///< of each pixel
    SourceChoice source;                                 ///< where voxels are too large
    std::uint64_t memoryLimit = std::uint64_t{8} << 30U; ///< of the source [bytes]
    std::string device;
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
};

/// Draws one complete picture and writes it. Returns the exit code.
int renderVoxels(const VoxelPictureRequest& request);

} // namespace isofront::cli
