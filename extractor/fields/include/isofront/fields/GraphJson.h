#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/fields/Graph.h>

#include <glm/vec2.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::fields::graph {

/// A graph with all that is needed to look at it. Solid is where the value is at or above 0.
struct Preset {
    std::string name;
    std::string description;
    Node surface = 0.0;
    std::vector<Material> materials; ///< may be none
    core::Box box;                   ///< the domain it is made for: a cube [field]
    glm::dvec2 start{0};             ///< where to begin a flight [field]
    glm::dvec2 lookAt{0};            ///< what to look at first [field]
    double clearance = 100;          ///< of the flight above the ground [field]
};

/// A file that a preset names, as one of its nodes.
struct FileRequest {
    enum class Kind { elevation, volume };

    Kind kind = Kind::elevation;
    std::string path = {}; ///< as seen from where the program runs
    // Of elevation rasters, instead of what the file says:
    std::optional<double> pixelSize = {};   ///< distance of two heights [m], > 0
    std::optional<double> heightScale = {}; ///< what one unit of the values means [m]
    std::optional<double> noData = {};      ///< the value of a missing height
    // Of volumes:
    std::optional<double> isovalue = {}; ///< in the file's values; by default one that is chosen
    std::string grid = {};               ///< of a VDB file
};

/// Loads a file as a field of the graph's own space in which solid is at or above 0. This floor
/// knows no files but its own, so whoever has readers hands them in.
using FileLoader = std::function<core::Result<std::shared_ptr<const Field>>(const FileRequest&)>;

/// What a preset's files are found with.
struct PresetFiles {
    std::string folder = {}; ///< relative paths start here; empty: the current one
    FileLoader load = {};    ///< empty: presets that name files are refused
};

/// Reads a preset from JSON; docs/presets.md describes the format. Whatever is not as described
/// there is bad data: the error names the line, or the node and the key, and says what would do.
/// An error of the loader keeps its code.
/// @param what  names the text in errors, such as its path
/// Thread: any.
core::Result<Preset>
parsePreset(std::string_view text, const std::string& what, const PresetFiles& files = {});

/// Reads a preset from a file of at most 1 MiB; files that it names are found from its folder.
core::Result<Preset> readPreset(const std::string& path, const FileLoader& load = {});

/// The preset as a field, with the materials as its attributes; see graphField.
std::shared_ptr<const Field> fieldOf(const Preset& preset, const GraphSettings& settings = {});

} // namespace isofront::fields::graph
