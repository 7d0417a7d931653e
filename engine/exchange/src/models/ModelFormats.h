#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <cstddef>
#include <span>

namespace isofront::exchange {

/// Each reads a whole file; messages don't name it.
core::Result<voxels::TriangleModel> readPly(std::span<const std::byte> bytes);
core::Result<voxels::TriangleModel> readStl(std::span<const std::byte> bytes);
core::Result<voxels::TriangleModel> readObj(std::span<const std::byte> bytes);

} // namespace isofront::exchange
