#pragma once

#include "Uploads.h"
#include "isofront/render/Renderer.h"
#include "shared/transition.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/SlabPool.h>
#include <isofront/surface/Delta.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

namespace isofront::render {

/// A cell whose mesh lies in the pool: first its vertices, then its indices.
struct StoredCell {
    surface::CellId id;
    hierarchy::LatticePoint corner;
    std::uint32_t exponent = 1;
    std::uint32_t vertexCount = 0;
    std::uint32_t indexCount = 0;
    gpu::SlabPool::Range range;           ///< [vertices]
    hierarchy::GridPoint low{0}, high{0}; ///< box around its vertices
    /// What it is part of: the pictures that shared/transition.h names, and `kInWanted`.
    std::uint32_t pictures = kEverywhere;

    static constexpr std::uint32_t kInWanted = 4; ///< shown after all deltas
    static constexpr std::uint32_t kEverywhere = shared::kInBoth | kInWanted;

    [[nodiscard]] std::int32_t vertexOffset() const
    {
        return static_cast<std::int32_t>(range.first);
    }
    [[nodiscard]] std::uint32_t firstIndex() const;
};

/// The meshes on the GPU, in one buffer made of slabs, kept in step with a surface by deltas.
///
/// Memory that a submitted frame may read is used again only when that frame is complete.
class MeshStore {
public:
    static core::Result<MeshStore> create(gpu::Device& device, const RendererOptions& options);

    /// As `Renderer::apply`.
    core::Result<UploadStats> apply(const surface::Delta& delta);
    /// As `Renderer::holdChanges`.
    void hold(bool hold);
    /// As `Renderer::beginTransition`.
    void beginTransition();
    void clear();

    /// Those that wait, or stay for a picture only, included.
    [[nodiscard]] std::span<const StoredCell> cells() const { return _cells; }
    /// Vertices and indices, both from its start.
    [[nodiscard]] const gpu::Buffer& buffer() const { return _buffer; }
    /// A colour for each place of a vertex; null if meshes have none.
    [[nodiscard]] const gpu::Buffer* colours() const { return _colours ? &*_colours : nullptr; }
    [[nodiscard]] std::size_t wanted() const { return _index.size(); } ///< cells after all deltas
    /// Cells that are part of any of these.
    [[nodiscard]] std::size_t countIn(std::uint32_t pictures) const;
    [[nodiscard]] std::uint64_t usedBytes() const;
    [[nodiscard]] std::uint64_t fadingBytes() const; ///< as `FrameStats::fadingBytes`
    [[nodiscard]] const gpu::SlabPool& pool() const { return _pool; }

private:
    MeshStore(gpu::Device& device, gpu::Buffer buffer, gpu::SlabPool pool);
    core::Result<void> check(const surface::Delta& delta) const;

    using Ranges = std::vector<gpu::SlabPool::Range>;
    struct Room {
        Ranges ranges; ///< one for each cell that is added
        /// The pool as it was, if the added meshes take the place of all that no delta wants.
        std::optional<gpu::SlabPool> before;
    };
    core::Result<Room> makeRoom(const surface::Delta& delta);
    void giveBack(Room room);
    std::optional<Ranges> allocate(const surface::Delta& delta);
    core::Result<std::uint64_t> upload(const surface::Delta& delta, const Room& room);
    core::Result<std::uint64_t> uploadColours(const surface::Delta& delta, const Room& room);
    core::Result<void> recycle();
    void retire(gpu::SlabPool::Range range);
    void takeAway(const surface::CellId& id, std::uint32_t keepers, bool retires);
    void forgetAllBut(std::uint32_t keepers, bool retires);
    void showAll();
    void erase(std::size_t place);
    core::Result<std::uint64_t> moveOutOfSparseSlab();

    struct Retired {
        gpu::Device::Ticket ticket = 0;
        gpu::SlabPool::Range range;
    };

    gpu::Device* _device;
    gpu::Buffer _buffer;
    std::optional<gpu::Buffer> _colours;
    gpu::SlabPool _pool;
    Uploads _uploads;
    std::vector<StoredCell> _cells;
    /// Those of them that are shown after all deltas.
    std::unordered_map<surface::CellId, std::size_t, surface::CellIdHash> _index;
    bool _holds = false;          ///< if not, every cell is part of everything
    std::deque<Retired> _retired; ///< in the order of their tickets
};

} // namespace isofront::render
