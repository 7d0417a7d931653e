#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Commands.h>
#include <isofront/gpu/Image.h>

#include <cstddef>
#include <vector>

namespace isofront::render {

/// Copies an image of four bytes a pixel to the CPU, rows from the top. Of several samples, the
/// first. Waits for all that was submitted.
/// @param now  how the image was last used; it is left so
core::Result<std::vector<std::byte>> copiedImage(
    gpu::Device& device, gpu::Commands& commands, const gpu::Image& image, const gpu::Use& now);

} // namespace isofront::render
