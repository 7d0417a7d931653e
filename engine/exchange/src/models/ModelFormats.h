#pragma once

#include <isofront/core/Result.h>
#include <isofront/exchange/ModelFile.h>
#include <isofront/voxels/TriangleModel.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace isofront::exchange {

/// What readers need beside the bytes of the file.
struct ModelContext {
    std::filesystem::path folder;         ///< where other files lie that it names
    std::uint64_t mostBytes = UINT64_MAX; ///< of each file and picture, and of the model
    /// Told how many of the first bytes aren't needed any more; may be null.
    std::function<void(std::size_t)> passed = nullptr;
    OtherFiles otherFiles = OtherFiles::read;
};

/// Each reads a whole file; messages don't name it.
core::Result<voxels::TriangleModel>
readPly(std::span<const std::byte> bytes, const ModelContext& context = {});
core::Result<voxels::TriangleModel>
readStl(std::span<const std::byte> bytes, const ModelContext& context = {});
core::Result<voxels::TriangleModel>
readObj(std::span<const std::byte> bytes, const ModelContext& context = {});
/// Text and binary alike.
core::Result<voxels::TriangleModel>
readGltf(std::span<const std::byte> bytes, const ModelContext& context = {});

} // namespace isofront::exchange
