#include <isofront/voxels/Chunk.h>
#include <isofront/voxels/ChunkDirectory.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace isofront::voxels {

namespace {

/// How many voxels of the next coarser level contain those of a chunk.
std::uint32_t parentsOf(const Chunk& chunk)
{
    // of two layers, one bit for each parent: layers follow each other
    std::array<std::uint64_t, 256> layer{};
    std::uint32_t z = kChunkEdge;
    std::uint32_t count = 0;
    for (const Voxel& voxel : chunk.voxels) {
        if (z != voxel.z() / 2) {
            z = voxel.z() / 2;
            layer.fill(0);
        }
        const std::uint32_t place = voxel.y() / 2 * (kChunkEdge / 2) + voxel.x() / 2;
        const std::uint64_t bit = std::uint64_t{1} << (place % 64);
        count += (layer[place / 64] & bit) == 0 ? 1U : 0U;
        layer[place / 64] |= bit;
    }
    return count;
}

} // namespace

std::string nameOf(const ChunkKey& key)
{
    return "chunk " + std::to_string(key.x) + ", " + std::to_string(key.y) + ", " +
           std::to_string(key.z) + " of level " + std::to_string(key.level);
}

FaceAttributes attributesOf(const Chunk& chunk, std::size_t voxel, Face face)
{
    const auto set = std::ranges::lower_bound(chunk.faceSets, voxel, {}, &FaceSet::voxel);
    if (set != chunk.faceSets.end() && set->voxel == voxel && (set->mask() & faceBit(face)) != 0)
        return chunk.faceAttributes[set->entry(face)];
    return {chunk.voxels[voxel].normal, chunk.colours.empty() ? 0 : chunk.colours[voxel]};
}

bool hasSoundFaces(const Chunk& chunk)
{
    std::size_t next = 0; // the first voxel that may have the next set
    return std::ranges::all_of(chunk.faceSets, [&](const FaceSet& set) {
        const std::size_t end =
            std::size_t{set.first()} + static_cast<std::size_t>(std::popcount(set.mask()));
        const bool inOrder = set.voxel >= next && set.voxel < chunk.voxels.size();
        next = std::size_t{set.voxel} + 1;
        return inOrder && end <= chunk.faceAttributes.size();
    });
}

std::vector<std::uint8_t> cappedFaces(const Chunk& chunk)
{
    constexpr std::uint32_t kLast = kChunkEdge - 1;
    // the masks of the low and of the high face along an axis
    const auto caps = [](std::uint32_t place) {
        return (place == 0 ? 1U : 0U) | (place == kLast ? 2U : 0U);
    };
    std::vector<std::uint8_t> faces(chunk.voxels.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Voxel& voxel = chunk.voxels[i];
        faces[i] = static_cast<std::uint8_t>(
            voxel.faces() | caps(voxel.x()) | caps(voxel.y()) << 2U | caps(voxel.z()) << 4U);
    }
    return faces;
}

ChunkEntry entryOf(const Chunk& chunk)
{
    ChunkEntry entry;
    entry.key = chunk.key;
    entry.voxels = static_cast<std::uint32_t>(chunk.voxels.size());
    entry.coloured = !chunk.colours.empty();
    entry.faceSets = static_cast<std::uint32_t>(chunk.faceSets.size());
    entry.faceAttributes = static_cast<std::uint32_t>(chunk.faceAttributes.size());
    entry.bytes = chunk.bytes();
    entry.parents = parentsOf(chunk);
    entry.low = {255, 255, 255};
    for (const Voxel& voxel : chunk.voxels) {
        const std::array<std::uint32_t, 3> place{voxel.x(), voxel.y(), voxel.z()};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto at = static_cast<std::uint8_t>(place[axis]);
            entry.low[axis] = std::min(entry.low[axis], at);
            entry.high[axis] = std::max(entry.high[axis], at);
        }
    }
    return entry;
}

} // namespace isofront::voxels
