#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/fields/Graph.h>

#include <glm/vec2.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace isofront::fields::graph {

/// A graph with all that is needed to look at it. Solid is where the value is at or above 0.
struct Preset {
    std::string name;
    std::string description;
    Node surface = 0.0;
    core::Box box;          ///< the domain it is made for: a cube [field]
    glm::dvec2 start{0};    ///< where to begin a flight [field]
    glm::dvec2 lookAt{0};   ///< what to look at first [field]
    double clearance = 100; ///< of the flight above the ground [field]
};

/// Reads a preset from JSON; docs/presets.md describes the format. Whatever is not as described
/// there is bad data: the error names the node and the key, and says what would do.
/// @param what  names the text in errors, such as its path
/// Thread: any.
core::Result<Preset> parsePreset(std::string_view text, const std::string& what);

/// Reads a preset from a file of at most 1 MiB.
core::Result<Preset> readPreset(const std::string& path);

} // namespace isofront::fields::graph
