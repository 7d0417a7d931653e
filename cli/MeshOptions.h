#pragma once

#include <isofront/core/Result.h>
#include <isofront/extractor/CellExtractor.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <string>

namespace isofront::cli {

/// What the commands offer of what cells do with their triangles after contouring.
struct MeshOptions {
    int smooth = 0;
    bool reproject = false;
    double simplify = 0;
    bool align = false;
    std::string vertices = "surface";
    std::string normals = "analytic";

    /// Adds the options to a command; they are written here.
    void addTo(CLI::App& command);
    /// Puts them into settings.
    void applyTo(extractor::ExtractionSettings& settings) const;
    /// As they are reported.
    void describe(nlohmann::ordered_json& json) const;
};

} // namespace isofront::cli
