#pragma once

#include "isofront/volume/LoadVolume.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

namespace isofront::volume {

/// What a header promises, read by our own code before a library sees the file: the libraries take
/// memory first and ask later, and MetaIO fills in what a file lacks without saying so.
struct FileHeader {
    enum class Encoding {
        raw,     ///< as many bytes as the voxels take
        deflate, ///< gzip or zlib
        text,    ///< decimal numbers
        hex,     ///< two characters a byte
        other,   ///< nothing is known of its size
    };

    std::array<std::int64_t, 3> dimensions{0, 0, 0};
    std::uint64_t voxelBytes = 0;
    Encoding encoding = Encoding::raw;
    std::filesystem::path dataFile; ///< where the voxels are; empty if spread over several files
    std::uint64_t dataOffset = 0;   ///< [bytes] what precedes the voxels in it, at least

    /// [bytes] how many compressed bytes the header counts; 0 if it doesn't say
    std::uint64_t packedBytes = 0;
    bool bigEndian = false;           ///< MetaImage: most significant bytes come first
    std::uint64_t unpackedOffset = 0; ///< [bytes] what precedes the voxels once they are unpacked

    /// Voxels times bytes; meaningful once `checkHeader` has passed.
    [[nodiscard]] std::uint64_t dataBytes() const;
};

core::Result<FileHeader> readNrrdHeader(const std::filesystem::path& path);
core::Result<FileHeader> readMetaImageHeader(const std::filesystem::path& path);
/// Fails if the dimensions are senseless, the data exceed the memory limit, or the file can't hold
/// them.
core::Result<void> checkHeader(const FileHeader& header, std::uint64_t memoryLimit);

/// Unpacks compressed data, into nothing, and fails if they are not all there. Teem notices that by
/// itself, but MetaIO doesn't: it leaves the rest unset.
/// @param header  one that `checkHeader` has passed
core::Result<void> checkCompressedData(const FileHeader& header);

/// Unpacks compressed data, in the byte order of this machine. Where a MetaImage has its data in
/// the same file and doesn't say how long they are, MetaIO unpacks the header, fails, and says
/// nothing.
/// @param header  one that `checkHeader` and `checkCompressedData` have passed
/// @param into    as many bytes as the header promises (asserted)
core::Result<void> readCompressedData(const FileHeader& header, std::span<std::byte> into);

} // namespace isofront::volume
