#pragma once

#include <isofront/core/Result.h>
#include <isofront/extractor/CellExtractor.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <optional>
#include <string>

namespace isofront::cli {

/// What the commands offer of what cells do with their triangles after contouring: a word for all
/// of it, and an option for each part, which wins over the word.
struct MeshOptions {
    std::optional<std::string> quality; ///< "plain" (where not given), "good" or "best"
    std::optional<int> smooth;
    std::optional<bool> reproject;
    std::optional<double> simplify;
    std::optional<bool> align;
    std::optional<std::string> vertices;
    std::string normals = "analytic";

    /// Adds the options to a command; they are written here.
    void addTo(CLI::App& command);
    /// Puts them into settings.
    void applyTo(extractor::ExtractionSettings& settings) const;
    /// As they are reported: what holds, whichever option it comes from.
    void describe(nlohmann::ordered_json& json) const;
};

} // namespace isofront::cli
