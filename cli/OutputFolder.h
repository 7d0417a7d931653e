#pragma once

#include <isofront/core/Result.h>

#include <filesystem>
#include <vector>

namespace isofront::cli {

/// A folder for what a command makes. Those that had to be made for it are removed in the end if
/// nothing was put into them.
class OutputFolder {
public:
    OutputFolder() = default;
    OutputFolder(const OutputFolder&) = delete;
    OutputFolder& operator=(const OutputFolder&) = delete;
    ~OutputFolder();

    /// Makes it, with all folders above, where it isn't there yet. At most once.
    /// @return inputOutput, with the option that named it
    core::Result<void> make(const std::filesystem::path& path);

private:
    std::vector<std::filesystem::path> _made; ///< the lowest last
};

} // namespace isofront::cli
