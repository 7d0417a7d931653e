#pragma once

#include "Console.h"
#include "SourceArguments.h"

#include <isofront/core/Box.h>
#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/HandOver.h>
#include <isofront/voxels/ChunkStore.h>

#include <CLI/CLI.hpp>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>

namespace isofront::cli {

/// What the user says about voxels in the distance.
struct FarFieldOptions {
    std::optional<std::string> voxels;                   ///< how many, or the path of a model
    double handOver = render::HandOverSettings{}.pixels; ///< [px]

    /// Adds the options to a command; they are written here.
    void addTo(CLI::App& command);
};

/// The same, understood.
struct FarFieldRequest {
    std::uint32_t resolution = 0; ///< along the longest edge; 0 for a model
    std::filesystem::path model;
};

/// For messages: what options of voxels have no effect on.
inline constexpr const char* kWithoutVoxels =
    "what is no voxel model and shown without --far-voxels";

/// Understands `--far-voxels`, before any work.
/// Errors: usage for what is neither a number in range nor a path, inputOutput for a file that
/// isn't there.
core::Result<std::optional<FarFieldRequest>> farFieldRequest(const FarFieldOptions& options);

/// Which surface a far field is to be of.
struct FarFieldSurface {
    double isovalue = 0; ///< in the source's own units
    double filter = 0;   ///< strength of the low-pass filter, of the meshes ...
    /// ... and of voxels that look like them: see render::voxelFilterFactor. A model may have
    /// either.
    double voxelFilter = 0;
    bool closed = false;
};

/// The voxels that stand for a source in the distance: a stored model of it, or made now and kept
/// in memory, without colours, as the meshes beside them have none.
/// @return usage for a model of another source, isovalue or filter; what opening a model and
/// voxelising a field say;
///         interrupted
core::Result<std::shared_ptr<const voxels::ChunkStore>> openFarField(
    const FarFieldRequest& request,
    const Source& source,
    const FarFieldSurface& surface,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop);

/// What to say where a far field is too coarse to take over anywhere within a scene, with how many
/// voxels would; empty if it does somewhere.
/// @param views  from which the scene is seen, at least one
std::string coarseFarFieldNote(
    const render::HandOver& handOver,
    std::uint32_t resolution,
    const core::Box& scene,
    std::span<const hierarchy::View> views);

} // namespace isofront::cli
