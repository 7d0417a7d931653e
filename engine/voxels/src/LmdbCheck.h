#pragma once

#include <isofront/core/Result.h>

#include <filesystem>
#include <optional>

namespace isofront::voxels {

/// Whether LMDB can read a file without leaving it: liblmdb trusts what it maps, and a damaged byte
/// of its tree can end the process.
///
/// Reads both meta pages and the tree of the newer one, with the layout of LMDB 0.9, as far as a
/// store has it: one table, without names or duplicates. Values are not read, only where they lie.
/// Nothing if it is in order; `badData` if it is damaged, cut short or something else,
/// `inputOutput` if it can't be read. Cost: a read for each page of the tree, in 100000 chunks
/// about 800.
std::optional<core::Error> lmdbDamage(const std::filesystem::path& path);

} // namespace isofront::voxels
