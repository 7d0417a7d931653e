#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace isofront::volume {

/// One grid of a VDB file, as the file's index has it.
struct VdbGridEntry {
    std::string name; ///< "name", or "name[1]" and so on where several grids have the same one
    std::string type; ///< such as "Tree_float_5_4_3"
};

/// Reads the index of a VDB file by our own code, because OpenVDB doesn't notice when a file is cut
/// short. Fails with badData unless the file is one, of format version 222 (OpenVDB 2.0) or later,
/// and every grid ends within it.
///
/// Source: openvdb/io/Archive.cc, File.cc and GridDescriptor.cc, OpenVDB 10.
core::Result<std::vector<VdbGridEntry>> readVdbHeader(const std::filesystem::path& path);

} // namespace isofront::volume
