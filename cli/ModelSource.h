#pragma once

#include "ModelView.h"

#include <isofront/hierarchy/View.h>
#include <isofront/render/HybridScene.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <string>

namespace isofront::cli {

/// What of the mesh file that a voxel model was made from is to be shown.
struct SourceChoice {
    std::string file; ///< where it is now; empty for where the model says
    bool isOff = false;

    void addTo(CLI::App& command);
};

/// Names of the options, for those who refuse what has no effect.
inline constexpr const char* kSourceOption = "--source";
inline constexpr const char* kNoSourceOption = "--no-source";

/// What a view needs to show a model's source where its finest voxels are too coarse.
struct ShownSource {
    render::SourceReader read; ///< empty for no source
    std::filesystem::path file;
};

/// The source of a model as it was chosen. Nothing is read before it is needed: then the file is
/// held against what the model says of it.
/// @param path         of the model
/// @param memoryLimit  of the file, unpacked, and of the triangles in it [bytes]
/// @return usage for a file where the model names none, or where none is to be shown
core::Result<ShownSource> sourceOf(
    const ShownModel& model,
    const std::filesystem::path& path,
    const SourceChoice& choice,
    std::uint64_t memoryLimit);

/// Whether a view has anything for which a source is needed.
bool needsSource(const ShownModel& model, const hierarchy::View& view, double voxelPixels);

/// What is to be said of the source in a frame, if anything.
std::string sourceNote(const render::HybridFrame& frame);

/// For `--json`; null without a source.
nlohmann::ordered_json sourceJson(const ShownSource& source, const render::HybridFrame& frame);

} // namespace isofront::cli
