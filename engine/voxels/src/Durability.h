#pragma once

#include <filesystem>
#include <string>

namespace isofront::voxels {

/// Waits until what a file or a folder contains survives if the machine goes down. Of a folder
/// these are the names in it, not what they name. 0, or an error number.
int makeDurable(const std::filesystem::path& path);

/// The folder that a file or a folder is in.
std::filesystem::path folderOf(const std::filesystem::path& path);

/// What an error number of writing says, and what to do about it if the disk may be full.
std::string writeFailure(int errorNumber);

} // namespace isofront::voxels
