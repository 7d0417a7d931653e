#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace isofront::server {

/// A file, or a folder of slices, that a scene can be made of.
struct SourceFile {
    std::string path;        ///< below the folder of sources, with slashes
    std::uint64_t bytes = 0; ///< 0 for a folder
};

/// All that scenes can be made of below a folder, sorted by path; the first 10,000.
std::vector<SourceFile> sourceFilesIn(const std::filesystem::path& folder);

/// Finds what a client names below a folder.
/// Errors: usage for paths that lead out of it, by links too, and for what isn't there.
core::Result<std::filesystem::path>
sourceFileIn(const std::filesystem::path& folder, const std::string& path);

/// The name that an upload is kept under: `name` without what file systems and shells care about.
/// Errors: usage for names whose files aren't read, or refer to other files.
core::Result<std::string> uploadName(const std::string& name);

/// A failure if an uploaded file refers to other files: volumes may say that their voxels lie
/// elsewhere, and those would be read from wherever a client says.
core::Result<void> checkSelfContained(const std::filesystem::path& file);

/// A failure if a formula names files.
core::Result<void> checkFormula(const std::string& text);

} // namespace isofront::server
