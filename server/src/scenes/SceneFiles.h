#pragma once

#include "SceneRecord.h"

#include <isofront/core/Result.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace isofront::server {

/// A file, or a folder of slices, that a scene can be made of.
struct SourceFile {
    std::string path;        ///< below the folder of sources, with slashes
    std::uint64_t bytes = 0; ///< 0 for a folder
};

struct SourceFiles {
    std::vector<SourceFile> files; ///< sorted by path
    bool isComplete = true;        ///< whether these are all that there are
};

/// What scenes can be made of below a folder: files whose names readers know, and folders of
/// slices. Links, hidden names and what is neither file nor folder don't count. Stops after 200,000
/// names.
/// @param most  of them that are listed
SourceFiles sourceFilesIn(const std::filesystem::path& folder, std::size_t most = 10'000);

/// The same for many who ask: the folder is walked again only after ten times as long as the last
/// walk took.
///
/// Thread: any.
class SourceFolder {
public:
    /// @param folder  none if empty
    explicit SourceFolder(std::filesystem::path folder) : _folder(std::move(folder)) {}

    SourceFiles files();

private:
    std::filesystem::path _folder;
    std::mutex _mutex;
    SourceFiles _files;
    std::chrono::steady_clock::time_point _nextWalk;
};

/// Finds what a client names below a folder, by the same rule: what isn't listed isn't there.
/// Errors: usage for paths that lead out of it, and for what isn't there.
core::Result<std::filesystem::path>
sourceFileIn(const std::filesystem::path& folder, const std::string& path);

/// The name that an upload is kept under: `name` without what file systems and shells care about.
/// Errors: usage for names whose files aren't read, or refer to other files.
core::Result<std::string> uploadName(const std::string& name);

/// A failure if an uploaded file refers to other files: volumes may say that their voxels lie
/// elsewhere, and those would be read from wherever a client says.
core::Result<void> checkSelfContained(const std::filesystem::path& file);

/// A failure if an option is given that has no effect on the kind of source, told by its name.
/// @param isFolder  whether it is a folder of slices
core::Result<void>
checkOptions(const sources::SourceOptions& options, const SceneOrigin& origin, bool isFolder);

/// A failure if a formula names files, or none can be made of it.
core::Result<void> checkFormula(const std::string& text);

} // namespace isofront::server
