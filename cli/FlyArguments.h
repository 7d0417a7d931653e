#pragma once

#include "DetailOptions.h"
#include "FarField.h"
#include "MeshOptions.h"
#include "ModelSource.h"
#include "SourceArguments.h"

#include <CLI/CLI.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

namespace isofront::cli {

/// What `fly` is asked for.
struct FlyArguments {
    std::string source; ///< empty for the terrain of `preset` and `seed`
    SourceArguments input;
    std::string preset = "alpine";
    std::optional<double> isovalue;
    std::uint64_t seed = 1;
    std::size_t frames = 240;
    double speed = 0;
    double fov = 60;
    std::string size = "1280x720";
    double pixelError = 3;
    double updateMilliseconds = 4;
    double fade = 0.25; ///< [s]
    bool measurePopping = false;
    FarFieldOptions far;
    double voxelPixels = 1; ///< of a model flown alone, as the next two
    std::string way = "auto";
    std::string up;
    SourceChoice sourceChoice;
    std::uint64_t cacheMib = 128; ///< for voxels on the device
    int lattice = 16;
    double filter = extractor::ExtractionSettings{}.filterStrength;
    MeshOptions mesh;
    DetailOptions detail;
    std::string out = "flight";
    int samples = 1;
    std::string device;
    std::size_t threads = 0;
    bool window = false;
    bool json = false;
    bool quiet = false;
    const CLI::App* command = nullptr; ///< that they came with
};

} // namespace isofront::cli
