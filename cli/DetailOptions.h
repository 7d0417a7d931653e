#pragma once

#include <isofront/core/Result.h>
#include <isofront/surface/Surface.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstddef>
#include <limits>
#include <string>
#include <vector>

namespace isofront::cli {

/// What is asked of detail beside the error in pixels, understood and in range.
struct DetailRequest {
    surface::DetailSettings settings;
    std::size_t maxCells = std::numeric_limits<std::size_t>::max();
    std::size_t maxTriangles = std::numeric_limits<std::size_t>::max();
    std::size_t maxBytes = std::numeric_limits<std::size_t>::max();

    /// Puts it into the options of a live surface.
    void applyTo(surface::SurfaceOptions& options) const;
    /// As it is reported: places of interest and the world's error.
    void describeDetail(nlohmann::ordered_json& json) const;
    /// The same of the ceilings; null where there is none.
    void describeCeilings(nlohmann::ordered_json& json) const;
};

/// What the commands offer of places of interest and ceilings.
struct DetailOptions {
    std::vector<std::string> focus; ///< "X,Y,Z,R,E" each
    double worldError = 0;
    std::size_t maxCells = 0; ///< 0 for no ceiling, as the others
    std::size_t maxTriangles = 0;
    std::string maxMemory;

    /// Adds the options of places to a command; they are written here.
    void addDetailTo(CLI::App& command);
    /// Adds those of ceilings.
    void addCeilingsTo(CLI::App& command);
    /// Errors: usage, for what is not a number or out of range.
    [[nodiscard]] core::Result<DetailRequest> request() const;
};

/// What a picture was made with, if ceilings left less than was asked for; else empty.
std::string coarserNote(double asked, double effective);

} // namespace isofront::cli
