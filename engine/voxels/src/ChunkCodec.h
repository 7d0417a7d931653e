#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace isofront::voxels {

/// A chunk as it lies in stores: a header of 32 bytes (magic number, version, key, counts, checksum
/// of what follows and of the header), the voxels, the colours, and if there are face sets, how
/// many sets and face attributes there are, and both; all little-endian.
std::vector<std::byte> encoded(const Chunk& chunk);

/// Reads one back, trusting nothing: `badData`, with what is wrong, for bytes that `encoded`
/// doesn't give for a chunk of that key.
core::Result<Chunk> decodedChunk(std::span<const std::byte> bytes, const ChunkKey& key);

/// What a model is, as a line of JSON that ends with a checksum: that of the same line without it.
std::string encoded(const StoredModel& model);
/// Reads one back, trusting nothing: `badData`, with what is wrong, for what `encoded` doesn't
/// give, and for another version.
core::Result<StoredModel> decodedModel(std::string_view text);

/// The directory of a store: a header of 16 bytes (magic number, version, how many, checksum of
/// what follows), then 48 bytes an entry; little-endian.
std::vector<std::byte> encoded(std::span<const ChunkEntry> directory);
core::Result<std::vector<ChunkEntry>> decodedDirectory(std::span<const std::byte> bytes);

} // namespace isofront::voxels
