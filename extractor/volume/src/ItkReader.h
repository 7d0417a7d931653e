#pragma once

#include "DenseVoxels.h"
#include "FileHeader.h"

#include <filesystem>

namespace isofront::volume {

/// Reads NRRD and MetaImage through ITK.
/// @param checked  the header as our own code has read it; it has passed `checkHeader`. Compressed
///                 MetaImages are unpacked by our own code, too. May throw what ITK
/// throws. Thread: any; calls wait for each other.
core::Result<DenseVoxels> readThroughItk(
    const std::filesystem::path& path,
    VolumeFormat format,
    const FileHeader& checked,
    const LoadOptions& options);

} // namespace isofront::volume
