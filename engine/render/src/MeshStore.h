#pragma once

#include "Uploads.h"
#include "isofront/render/Renderer.h"

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
    void clear();

    [[nodiscard]] std::span<const StoredCell> cells() const { return _cells; }
    /// Vertices and indices, both from its start.
    [[nodiscard]] const gpu::Buffer& buffer() const { return _buffer; }
    [[nodiscard]] std::uint64_t usedBytes() const;
    [[nodiscard]] const gpu::SlabPool& pool() const { return _pool; }

private:
    MeshStore(gpu::Device& device, gpu::Buffer buffer, gpu::SlabPool pool);
    core::Result<void> check(const surface::Delta& delta) const;

    using Ranges = std::vector<gpu::SlabPool::Range>;
    struct Room {
        Ranges ranges; ///< one for each cell that is added
        /// The pool as it was, if the added meshes take the place of the removed ones.
        std::optional<gpu::SlabPool> before;
    };
    core::Result<Room> makeRoom(const surface::Delta& delta);
    void giveBack(Room room);
    std::optional<Ranges> allocate(const surface::Delta& delta);
    core::Result<std::uint64_t> upload(const surface::Delta& delta, const Room& room);
    core::Result<void> recycle();
    void retire(gpu::SlabPool::Range range);
    void erase(const surface::CellId& id);
    core::Result<std::uint64_t> moveOutOfSparseSlab();

    struct Retired {
        gpu::Device::Ticket ticket = 0;
        gpu::SlabPool::Range range;
    };

    gpu::Device* _device;
    gpu::Buffer _buffer;
    gpu::SlabPool _pool;
    Uploads _uploads;
    std::vector<StoredCell> _cells;
    std::unordered_map<surface::CellId, std::size_t, surface::CellIdHash> _index;
    std::deque<Retired> _retired; ///< in the order of their tickets
};

} // namespace isofront::render
