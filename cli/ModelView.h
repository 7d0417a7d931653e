#pragma once

#include "Pictures.h"

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <CLI/CLI.hpp>
#include <glm/vec3.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

namespace isofront::cli {

/// A stored model of voxels that is to be shown by itself.
struct ShownModel {
    std::shared_ptr<const voxels::ChunkStore> store;
    core::Box box;      ///< of its voxels, not empty [world]
    glm::dvec3 up{0.0}; ///< of length 1 [world]
    bool isLandscape = false;
};

/// Opens a model to be shown.
/// @param up  away from its ground; if it isn't given, y for meshes and level sets, and z for
///            scans, landscapes and formulas
/// @return what opening a store says; badData for a model without voxels
core::Result<ShownModel>
openModel(const std::filesystem::path& path, const std::optional<glm::dvec3>& up);

/// Where to look to see a model from the right of its front, and from above, of length 1.
glm::dvec3 forwardTo(const ShownModel& model);

/// So far from an eye that the sun's map covers all that a view shows of a model [world].
double shadowDistance(const ShownModel& model, const glm::dvec3& eye);

/// A renderer for a model, without room for meshes unless it has a source. Landscapes get their own
/// light and ground, all else is an object before a wall.
/// @return noDevice if there is none that fits, resourceLimit if it has too little memory
core::Result<Studio> openStudio(const ShownModel& model, const StudioOptions& options);

/// "X,Y,Z" of `--up`, or nothing for an empty text. Errors: usage.
core::Result<std::optional<glm::dvec3>> parseUp(const std::string& text);
/// Adds what decides how voxels are shown; the values are written here.
void addVoxelOptions(CLI::App& command, double& voxelPixels, std::string& way, std::string& up);
/// Adds `--cache-mib`.
/// @param whose  as "voxel models: "
void addCacheOption(CLI::App& command, std::uint64_t& mib, const std::string& whose);
/// A failure to show voxels; one for want of room names `--cache-mib`.
core::Error withCache(const core::Error& error, std::uint64_t cacheBytes);
/// What voxels were shown with, if their cache left less than was asked for; else empty.
/// @param asked, effective  of the largest voxel [px]
std::string coarserVoxelsNote(double asked, double effective, std::uint64_t cacheBytes);
/// Of the word that `--way` has taken.
render::VoxelWay voxelWay(const std::string& word);

} // namespace isofront::cli
