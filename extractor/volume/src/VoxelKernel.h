#pragma once

#include <glm/ext/vector_int3_sized.hpp>

#include <cstddef>
#include <cstdint>

namespace isofront::volume::detail {

/// Trilinear interpolation of the voxels of a dense volume at many points, by the best instruction
/// set that the machine has: the same bits as VoxelGrid::sample, on each of them.
///
/// @param size    voxels along each axis, at least 1
/// @param voxels  x fastest, then y
/// @param px      coordinates of the points, any numbers, clamped to the voxels
/// @return false, and nothing done, if there is no such kernel for the volume: voxels of other
///         types, volumes of 2 GiB and more, and machines that can't gather
bool sampleVoxels(
    const glm::ivec3& size,
    const std::int8_t* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out);
bool sampleVoxels(
    const glm::ivec3& size,
    const std::uint8_t* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out);
bool sampleVoxels(
    const glm::ivec3& size,
    const std::int16_t* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out);
bool sampleVoxels(
    const glm::ivec3& size,
    const std::uint16_t* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out);
bool sampleVoxels(
    const glm::ivec3& size,
    const float* voxels,
    const double* px,
    const double* py,
    const double* pz,
    std::size_t count,
    float* out);

} // namespace isofront::volume::detail
