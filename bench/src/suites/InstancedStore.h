#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkStore.h>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace isofront::bench {

/// A model of voxels placed over and over, side by side along x and y: a store that holds the
/// chunks of one, and of each coarser level the one chunk of which that level consists. So a city
/// of any size takes the memory of a block of it.
///
/// Immutable. Thread: any number at once.
class InstancedStore : public voxels::ChunkStore {
public:
    /// @param one        a finished store of a model that is a power of two of chunks along an
    /// edge,
    ///                   all of which it fills along x and y. Held.
    /// @param doublings  2^doublings of them along x, and along y
    /// @return badData for another model; what the store says, if it can't be read
    static core::Result<std::shared_ptr<const InstancedStore>>
    create(std::shared_ptr<const voxels::ChunkStore> one, std::uint32_t doublings);

    /// Takes nothing: usage.
    std::optional<core::Error> put(voxels::Chunk chunk) override;
    std::optional<core::Error> finish(const voxels::StoredModel& model) override;

    [[nodiscard]] const voxels::StoredModel& model() const override { return _model; }
    [[nodiscard]] std::vector<voxels::ChunkKey> keys() const override;
    [[nodiscard]] core::Result<std::vector<voxels::ChunkEntry>> directory() const override;
    [[nodiscard]] core::Result<std::optional<voxels::Chunk>>
    get(const voxels::ChunkKey& key) const override;

private:
    InstancedStore() = default;

    std::shared_ptr<const voxels::ChunkStore> _one;
    std::uint32_t _ownLevels = 1;         ///< of one; at the last it is one chunk
    std::vector<voxels::Chunk> _coarser;  ///< of the levels from `_ownLevels` on
    std::vector<voxels::ChunkEntry> _all; ///< of all copies
    voxels::StoredModel _model;
};

} // namespace isofront::bench
