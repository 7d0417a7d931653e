#pragma once

#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/TriangleModel.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>

namespace isofront::cli {

/// A box as it is reported; null if it is empty.
nlohmann::ordered_json boxJson(const core::Box& box);

/// What a mesh file holds, and what is unusual in it.
nlohmann::ordered_json
meshJson(const voxels::TriangleModel& model, const voxels::ModelReport& report);

/// What a stored model of voxels is.
nlohmann::ordered_json modelJson(const voxels::StoredModel& model);

/// What a file, or a folder with all that is in it, takes on the disk; 0 if it isn't there [bytes].
std::uint64_t bytesOnDisk(const std::filesystem::path& path);

} // namespace isofront::cli
