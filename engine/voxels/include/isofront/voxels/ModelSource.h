#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <stop_token>
#include <string>

namespace isofront::voxels {

/// The mesh file that a model was made from, by what it can be found and known again.
struct ModelSource {
    /// Absolute; or from the model's folder, if the file lies in that or below it: so both can be
    /// moved together.
    std::string path;
    std::uint64_t bytes = 0;    ///< of the file, as it lies there
    std::uint32_t checksum = 0; ///< CRC-32 of the same

    friend bool operator==(const ModelSource&, const ModelSource&) = default;
};

/// What to keep of a file for a model that is made from it. Reads the file once.
/// @param model  where the model will lie
/// @return inputOutput if the file can't be read
core::Result<ModelSource>
describedSource(const std::filesystem::path& file, const std::filesystem::path& model);

/// Where a model's source should be.
std::filesystem::path placeOfSource(const ModelSource& source, const std::filesystem::path& model);

/// Whether a file is the one that was described: by its size first, then by its checksum. Only the
/// file itself is looked at, not what it names, as glTF and OBJ do with buffers and pictures.
/// @param stop  asked while the file is read
/// @return inputOutput if it isn't there or can't be read, badData if it is another one;
///         interrupted
core::Result<void> checkSource(
    const ModelSource& source, const std::filesystem::path& file, const std::stop_token& stop = {});

} // namespace isofront::voxels
