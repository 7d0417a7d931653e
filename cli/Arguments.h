#pragma once

#include <isofront/core/Result.h>

#include <CLI/CLI.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::cli {

/// A command: what it is called with is in its App, and this is what it does. Returns the exit
/// code.
using Action = std::function<int()>;

struct PictureSize {
    int width = 1280;
    int height = 720;
};

/// Accepts finite numbers from `low` to `high`; the library's own range lets NaN through.
CLI::Validator within(double low, double high);
/// Accepts numbers that field values can be compared with: finite, and not beyond a quarter of the
/// largest float.
CLI::Validator isovalues();

/// "1280x720", each side from 1 to 16384.
core::Result<PictureSize> parseSize(const std::string& text);
/// True if the folder of a file to write is there; otherwise the failure that writing would end in,
/// told before any work is done.
core::Result<void> checkFolderOf(const std::string& file);
/// Adds `--msaa`, the samples of each pixel.
void addSamples(CLI::App& command, int& samples);
/// A positive, finite number of pixels.
core::Result<void> checkPixelError(double pixels);
/// Refuses options that were given but would change nothing.
/// @param ok    long names of those that don't, as "--size"
/// @param what  the source is, as "a mesh"
core::Result<void> checkOptions(
    const CLI::App& command, std::initializer_list<std::string_view> ok, const std::string& what);
/// The same the other way round.
core::Result<void> checkNoOptions(
    const CLI::App& command,
    std::initializer_list<std::string_view> wrong,
    const std::string& what);
/// A failure; one for want of room says besides which option gives more of it, and what that is.
/// @param option  as "--memory-limit"
core::Error
withOption(const core::Error& error, const std::string& option, const std::string& value);
/// "1.5,-2,3e4", so many finite numbers and nothing else; nothing if it isn't that.
std::optional<std::vector<double>> parseNumbers(std::string_view text, std::size_t count);
/// "1.5,-2,3e4", three finite numbers.
core::Result<glm::dvec3> parsePoint(const std::string& text, const char* option);

// Each adds a subcommand to the app and returns what to do if it is chosen.
Action addBench(CLI::App& app);
Action addExtract(CLI::App& app);
Action addInfo(CLI::App& app);
Action addFly(CLI::App& app);
Action addRender(CLI::App& app);
Action addServe(CLI::App& app);
Action addTiles(CLI::App& app);
Action addVoxelize(CLI::App& app);

} // namespace isofront::cli
