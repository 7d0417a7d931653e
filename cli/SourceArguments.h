#pragma once

#include <isofront/core/Result.h>
#include <isofront/sources/Source.h>

#include <CLI/CLI.hpp>

#include <optional>
#include <stop_token>
#include <string>

namespace isofront::cli {

using sources::checksumOf;
using sources::levelForStep;
using sources::openSource;
using sources::Source;
using sources::SourceOptions;

/// What the user says about a source: the same options in every command that opens one.
struct SourceArguments {
    std::string grid;
    std::string series;
    std::string rawLayout;
    std::string voxelSize;
    double memoryLimitGib = 8;
    std::string pixelSize;
    std::optional<double> heightScale;
    std::optional<double> noData;
    int meshResolution = 256;
    std::optional<double> meshReach;
    std::string detail = "none"; ///< a command that shows sources sets another one
};

/// Adds SOURCE to a command, with the kinds there are; `text` must outlive it.
CLI::Option* addSource(CLI::App& command, std::string& text);

/// Adds the options to a command; `arguments` must outlive it.
void addSourceArguments(CLI::App& command, SourceArguments& arguments);

/// Errors: usage for texts that are not what an option wants.
core::Result<SourceOptions> sourceOptions(const SourceArguments& arguments, std::stop_token stop);

/// What `--memory-limit` says [bytes].
std::uint64_t memoryLimit(const SourceArguments& arguments);

/// A failure to open a source; one for want of room names `--memory-limit`.
core::Error withMemoryLimit(const core::Error& error, const SourceArguments& arguments);

/// What to say where nobody has given an isovalue for a volume.
std::string isovalueNote(double isovalue);

/// Opens a source with what the user says about it.
core::Result<Source>
openSource(const std::string& text, const SourceArguments& arguments, std::stop_token stop);

} // namespace isofront::cli
