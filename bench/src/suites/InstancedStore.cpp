#include "InstancedStore.h"

#include <isofront/voxels/ChunkDirectory.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace isofront::bench {

namespace {

using voxels::Chunk;
using voxels::ChunkEntry;
using voxels::ChunkKey;
using voxels::Voxel;

/// Four copies of a chunk, side by side, at half the resolution.
Chunk fourOf(const Chunk& child)
{
    struct Merged {
        std::uint8_t faces = 0;
        glm::dvec3 normal{0.0};
        std::uint32_t first = 0; ///< normal of the first
    };
    std::map<std::uint32_t, Merged> merged; // by z, y, x
    for (const Voxel& voxel : child.voxels) {
        const std::uint32_t place =
            voxels::packPlace(voxel.x() / 2, voxel.y() / 2, voxel.z() / 2, 0);
        const auto [at, isNew] = merged.try_emplace(place);
        if (isNew)
            at->second.first = voxel.normal;
        at->second.faces |= voxel.faces();
        at->second.normal += voxels::unpackNormal(voxel.normal);
    }
    Chunk parent;
    parent.key = {child.key.level + 1, 0, 0, 0};
    constexpr std::uint32_t kHalf = voxels::kChunkEdge / 2;
    for (const std::uint32_t y : {0U, kHalf})
        for (const std::uint32_t x : {0U, kHalf})
            for (const auto& [place, sum] : merged) {
                const Voxel half{place, 0};
                const bool isFlat = sum.normal == glm::dvec3(0.0);
                parent.voxels.push_back(
                    {voxels::packPlace(half.x() + x, half.y() + y, half.z(), sum.faces),
                     isFlat ? sum.first : voxels::packNormal(sum.normal)});
            }
    std::ranges::sort(parent.voxels, {}, &Voxel::order);
    return parent;
}

std::optional<core::Error> refused()
{
    return core::Error{core::ErrorCode::usage, "copies of a model can't be written to"};
}

} // namespace

core::Result<std::shared_ptr<const InstancedStore>>
InstancedStore::create(std::shared_ptr<const voxels::ChunkStore> one, std::uint32_t doublings)
{
    const voxels::StoredModel& own = one->model();
    const std::uint32_t levels = own.lattice.levels;
    if (own.coloured || own.lattice.resolution != voxels::kChunkEdge << (levels - 1))
        return core::failure(
            core::ErrorCode::badData,
            "copies need a model without colours that fills a power of two of chunks");
    const auto entries = one->directory();
    if (!entries)
        return tl::unexpected(entries.error());
    const auto root = one->get({levels - 1, 0, 0, 0});
    if (!root)
        return tl::unexpected(root.error());
    if (!*root)
        return core::failure(core::ErrorCode::badData, "the model has no coarsest chunk");

    std::shared_ptr<InstancedStore> store(new InstancedStore);
    store->_ownLevels = levels;
    store->_model = own;
    store->_model.lattice.resolution <<= doublings;
    store->_model.lattice.levels += doublings;
    store->_model.voxels <<= 2 * doublings;
    Chunk coarser = **root;
    coarser.faceSets.clear();
    coarser.faceAttributes.clear();
    for (std::uint32_t i = 0; i < doublings; ++i) {
        coarser = fourOf(coarser);
        store->_coarser.push_back(coarser);
    }
    const auto addCopies = [&](const ChunkEntry& entry, std::uint32_t copies, std::uint32_t apart) {
        for (std::uint32_t y = 0; y < copies; ++y)
            for (std::uint32_t x = 0; x < copies; ++x) {
                ChunkEntry copy = entry;
                copy.key.x += x * apart;
                copy.key.y += y * apart;
                store->_all.push_back(copy);
            }
        store->_model.allVoxels += std::uint64_t{copies} * copies * entry.voxels;
    };
    store->_model.allVoxels = 0;
    for (const ChunkEntry& entry : *entries)
        addCopies(entry, 1U << doublings, 1U << (levels - 1 - entry.key.level));
    for (std::uint32_t i = 0; i < doublings; ++i)
        addCopies(voxels::entryOf(store->_coarser[i]), 1U << (doublings - 1 - i), 1);
    store->_model.chunks = store->_all.size();
    store->_one = std::move(one);
    return store;
}

std::optional<core::Error> InstancedStore::put(voxels::Chunk /*chunk*/)
{
    return refused();
}

std::optional<core::Error> InstancedStore::finish(const voxels::StoredModel& /*model*/)
{
    return refused();
}

std::vector<ChunkKey> InstancedStore::keys() const
{
    std::vector<ChunkKey> keys;
    for (const ChunkEntry& entry : _all)
        keys.push_back(entry.key);
    std::ranges::sort(keys, {}, [](const ChunkKey& key) {
        return std::array{key.level, key.z, key.y, key.x};
    });
    return keys;
}

core::Result<std::vector<ChunkEntry>> InstancedStore::directory() const
{
    return _all;
}

core::Result<std::optional<Chunk>> InstancedStore::get(const ChunkKey& key) const
{
    if (key.level >= _model.lattice.levels)
        return std::nullopt;
    const std::uint32_t across = 1U << (_model.lattice.levels - 1 - key.level);
    if (key.x >= across || key.y >= across)
        return std::nullopt;
    std::optional<Chunk> chunk;
    if (key.level >= _ownLevels) {
        if (key.z == 0)
            chunk = _coarser[key.level - _ownLevels];
    } else {
        const std::uint32_t own = 1U << (_ownLevels - 1 - key.level);
        auto found = _one->get({key.level, key.x % own, key.y % own, key.z});
        if (!found)
            return found;
        chunk = std::move(*found);
    }
    if (chunk)
        chunk->key = key;
    return chunk;
}

} // namespace isofront::bench
