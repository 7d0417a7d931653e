#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/VoxelRay.h>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace isofront::cli {

/// A ray as it is given, "X,Y,Z,DX,DY,DZ": start and direction [world].
core::Result<voxels::Ray> parseRay(const std::string& text);

/// The first voxel of a level that a ray meets, if it meets one. `usage` for a level that the model
/// doesn't have.
core::Result<std::optional<voxels::VoxelHit>>
castRay(const voxels::ChunkStore& store, const voxels::Ray& ray, std::uint32_t level);

/// Null for none.
nlohmann::ordered_json hitJson(const std::optional<voxels::VoxelHit>& hit, const voxels::Ray& ray);
/// For people.
std::string hitText(const std::optional<voxels::VoxelHit>& hit, const voxels::Ray& ray);

} // namespace isofront::cli
