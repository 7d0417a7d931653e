#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>

#include <glm/ext/vector_int2.hpp>

#include <span>

namespace isofront::render {

/// Whether a renderer's pictures may have so many samples a pixel: `usage` for numbers but 1, 4 and
/// 8; `noDevice`, with those that there are, if the device doesn't have them.
core::Result<void> checkSamples(const gpu::Device& device, int samples);

/// Vulkan's standard places, from the pixel's upper left corner [1/16 px].
/// @param samples  1, 4 or 8
std::span<const glm::ivec2> samplePlaces(int samples);

} // namespace isofront::render
