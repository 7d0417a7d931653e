#pragma once

#include <string>

namespace isofront::server {

/// A message of a lower floor as clients should read it: without a folder of this machine, and with
/// the names that requests have for what is an option to the command (`--voxel-size` is
/// `option voxel_size`).
/// @param folder  with a slash at the end; empty: none
std::string inClientWords(std::string message, const std::string& folder);

} // namespace isofront::server
