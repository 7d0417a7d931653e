#include "MeshStore.h"

#include <isofront/core/Assert.h>

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <unordered_set>

namespace isofront::render {

namespace {

constexpr std::uint32_t kVertexBytes = sizeof(extractor::CellVertex);
constexpr std::uint32_t kColourBytes = sizeof(std::uint32_t);
constexpr std::uint32_t kIndicesAVertex = kVertexBytes / sizeof(std::uint16_t);

/// Room that a mesh takes, indices included [vertices].
std::uint64_t unitsOf(const extractor::CellMesh& mesh)
{
    if (mesh.indices.empty())
        return 0;
    return mesh.vertices.size() + (mesh.indices.size() + kIndicesAVertex - 1) / kIndicesAVertex;
}

core::Result<void> checkMesh(const extractor::CellMesh& mesh)
{
    const auto bad = [](const std::string& what) {
        return core::failure(
            core::ErrorCode::badData, "a cell mesh " + what + ", so its delta can't be shown");
    };
    if (mesh.exponent < 1 || mesh.exponent > 32)
        return bad("has the exponent " + std::to_string(mesh.exponent) + ", not 1 to 32");
    if (mesh.indices.size() % 3 != 0)
        return bad("has an incomplete triangle");
    const auto largest = std::max_element(mesh.indices.begin(), mesh.indices.end());
    if (!mesh.attributes.empty() && mesh.attributes.size() != mesh.vertices.size())
        return bad(
            "has " + std::to_string(mesh.attributes.size()) + " attributes for " +
            std::to_string(mesh.vertices.size()) + " vertices");
    if (largest != mesh.indices.end() && *largest >= mesh.vertices.size())
        return bad(
            "names vertex " + std::to_string(*largest) + " of " +
            std::to_string(mesh.vertices.size()));
    return {};
}

StoredCell stored(const surface::ShownCell& shown, gpu::SlabPool::Range range)
{
    const extractor::CellMesh& mesh = *shown.mesh();
    StoredCell cell;
    cell.id = shown.id;
    cell.corner = mesh.low;
    cell.exponent = mesh.exponent;
    cell.range = range;
    if (mesh.indices.empty())
        return cell;
    cell.vertexCount = static_cast<std::uint32_t>(mesh.vertices.size());
    cell.indexCount = static_cast<std::uint32_t>(mesh.indices.size());
    std::array<std::uint16_t, 3> low = mesh.vertices.front().position;
    std::array<std::uint16_t, 3> high = low;
    for (const extractor::CellVertex& vertex : mesh.vertices) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], vertex.position[axis]);
            high[axis] = std::max(high[axis], vertex.position[axis]);
        }
    }
    cell.low = mesh.gridPosition({.position = low});
    cell.high = mesh.gridPosition({.position = high});
    return cell;
}

void copyInto(std::span<std::byte> place, const extractor::CellMesh& mesh)
{
    const std::size_t vertexBytes = mesh.vertices.size() * kVertexBytes;
    std::memcpy(place.data(), mesh.vertices.data(), vertexBytes);
    std::memcpy(
        place.data() + vertexBytes,
        mesh.indices.data(),
        mesh.indices.size() * sizeof(std::uint16_t));
}

std::size_t bytesOf(const extractor::CellMesh& mesh)
{
    return mesh.vertices.size() * kVertexBytes + mesh.indices.size() * sizeof(std::uint16_t);
}

} // namespace

std::uint32_t StoredCell::firstIndex() const
{
    return (range.first + vertexCount) * kIndicesAVertex;
}

MeshStore::MeshStore(gpu::Device& device, gpu::Buffer buffer, gpu::SlabPool pool)
    : _device(&device), _buffer(std::move(buffer)), _pool(std::move(pool)), _uploads(device)
{
}

core::Result<MeshStore> MeshStore::create(gpu::Device& device, const RendererOptions& options)
{
    const std::uint32_t slabUnits = (options.slabBytes + kVertexBytes - 1) / kVertexBytes;
    const std::uint64_t slabs =
        options.poolBytes / (std::uint64_t{std::max(slabUnits, 1U)} * kVertexBytes);
    // Indices are counted in 32 bits from the pool's start.
    constexpr std::uint64_t kMostBytes = (1ULL << 32U) * sizeof(std::uint16_t);
    if (slabUnits == 0 || slabs == 0 || options.poolBytes > kMostBytes) {
        return core::failure(
            core::ErrorCode::usage,
            "a mesh pool of " + std::to_string(options.poolBytes) + " bytes in slabs of " +
                std::to_string(options.slabBytes) +
                " is not possible; use at least one slab and at most 8 GiB");
    }
    const gpu::MemoryKind kind = options.forceStaging || !gpu::hasSharedMemory(device)
                                     ? gpu::MemoryKind::device
                                     : gpu::MemoryKind::shared;
    core::Result<gpu::Buffer> buffer = gpu::Buffer::create(
        device,
        slabs * slabUnits * kVertexBytes,
        VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_INDEX_BUFFER_BIT |
            VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        kind);
    if (!buffer)
        return tl::unexpected(buffer.error());
    MeshStore store(
        device, std::move(*buffer), gpu::SlabPool(static_cast<std::uint32_t>(slabs), slabUnits));
    if (!options.meshColours)
        return store;
    core::Result<gpu::Buffer> colours = gpu::Buffer::create(
        device,
        slabs * slabUnits * kColourBytes,
        VK_BUFFER_USAGE_VERTEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT |
            VK_BUFFER_USAGE_TRANSFER_DST_BIT,
        kind);
    if (!colours)
        return tl::unexpected(colours.error());
    store._colours = std::move(*colours);
    return store;
}

core::Result<void> MeshStore::check(const surface::Delta& delta) const
{
    const auto misstep = [&](const char* what) {
        return core::failure(
            core::ErrorCode::usage,
            "delta " + std::to_string(delta.version) + " " + what +
                "; apply every delta of one surface, in order");
    };
    std::unordered_set<surface::CellId, surface::CellIdHash> removed;
    for (const surface::CellId& id : delta.removed) {
        if (!_index.contains(id) || !removed.insert(id).second)
            return misstep("removes a cell that is not shown");
    }
    std::unordered_set<surface::CellId, surface::CellIdHash> added;
    for (const surface::ShownCell& cell : delta.added) {
        const bool stays = _index.contains(cell.id) && !removed.contains(cell.id);
        if (stays || !added.insert(cell.id).second)
            return misstep("adds a cell that is already shown");
        if (core::Result<void> sound = checkMesh(*cell.mesh()); !sound)
            return sound;
    }
    return {};
}

std::optional<MeshStore::Ranges> MeshStore::allocate(const surface::Delta& delta)
{
    Ranges ranges;
    for (const surface::ShownCell& cell : delta.added) {
        const std::uint64_t units = unitsOf(*cell.mesh());
        const std::optional<gpu::SlabPool::Range> range =
            units > _pool.capacity() ? std::nullopt
                                     : _pool.allocate(static_cast<std::uint32_t>(units));
        if (!range) {
            for (const gpu::SlabPool::Range& taken : ranges)
                _pool.release(taken);
            return std::nullopt;
        }
        ranges.push_back(*range);
    }
    return ranges;
}

core::Result<void> MeshStore::recycle()
{
    if (_retired.empty())
        return {};
    const core::Result<gpu::Device::Ticket> completed = _device->completed();
    if (!completed)
        return tl::unexpected(completed.error());
    while (!_retired.empty() && _retired.front().ticket <= *completed) {
        _pool.release(_retired.front().range);
        _retired.pop_front();
    }
    return {};
}

void MeshStore::retire(gpu::SlabPool::Range range)
{
    if (range.count > 0)
        _retired.push_back({_device->submitted(), range});
}

/// Finds ranges for all that is added. If memory is short, waits for the frames in flight and lets
/// the added meshes take the place of the removed ones, which can then no longer fade.
core::Result<MeshStore::Room> MeshStore::makeRoom(const surface::Delta& delta)
{
    if (core::Result<void> recycled = recycle(); !recycled)
        return tl::unexpected(recycled.error());
    if (std::optional<Ranges> ranges = allocate(delta))
        return Room{std::move(*ranges), std::nullopt};
    if (core::Result<void> idle = _device->wait(_device->submitted()); !idle)
        return tl::unexpected(idle.error());
    if (core::Result<void> recycled = recycle(); !recycled)
        return tl::unexpected(recycled.error());
    gpu::SlabPool before = _pool;
    for (const surface::CellId& id : delta.removed)
        _pool.release(_cells[_index.at(id)].range);
    for (const StoredCell& cell : _cells) {
        if ((cell.pictures & StoredCell::kInWanted) == 0)
            _pool.release(cell.range);
    }
    if (std::optional<Ranges> ranges = allocate(delta))
        return Room{std::move(*ranges), std::move(before)};
    _pool = std::move(before);
    return core::failure(
        core::ErrorCode::resourceLimit,
        "the meshes don't fit into the renderer's pool of " + std::to_string(_buffer.bytes()) +
            " bytes; ask for less detail or give it a larger pool");
}

void MeshStore::giveBack(Room room)
{
    if (room.before) {
        _pool = std::move(*room.before);
        return;
    }
    for (const gpu::SlabPool::Range& range : room.ranges)
        _pool.release(range);
}

core::Result<std::uint64_t> MeshStore::upload(const surface::Delta& delta, const Room& room)
{
    std::uint64_t bytes = 0;
    for (const surface::ShownCell& cell : delta.added)
        bytes += bytesOf(*cell.mesh());
    core::Result<UploadBatch> batch = _uploads.open(_buffer, bytes);
    if (!batch)
        return tl::unexpected(batch.error());
    for (std::size_t i = 0; i < delta.added.size(); ++i) {
        const extractor::CellMesh& mesh = *delta.added[i].mesh();
        if (mesh.indices.empty())
            continue;
        const VkDeviceSize offset = VkDeviceSize{room.ranges[i].first} * kVertexBytes;
        copyInto(batch->place(offset, bytesOf(mesh)), mesh);
    }
    if (core::Result<void> submitted = _uploads.submit(_buffer, *batch); !submitted)
        return tl::unexpected(submitted.error());
    if (!_colours)
        return bytes;
    const core::Result<std::uint64_t> coloured = uploadColours(delta, room);
    if (!coloured)
        return coloured;
    return bytes + *coloured;
}

/// Meshes without colours get the word that says so.
core::Result<std::uint64_t> MeshStore::uploadColours(const surface::Delta& delta, const Room& room)
{
    std::uint64_t bytes = 0;
    for (const surface::ShownCell& cell : delta.added)
        bytes += cell.mesh()->vertices.size() * kColourBytes;
    core::Result<UploadBatch> batch = _uploads.open(*_colours, bytes);
    if (!batch)
        return tl::unexpected(batch.error());
    for (std::size_t i = 0; i < delta.added.size(); ++i) {
        const extractor::CellMesh& mesh = *delta.added[i].mesh();
        if (mesh.indices.empty())
            continue;
        const std::span<std::byte> place = batch->place(
            VkDeviceSize{room.ranges[i].first} * kColourBytes, mesh.vertices.size() * kColourBytes);
        if (mesh.attributes.empty())
            std::ranges::fill(place, std::byte{0});
        else
            std::memcpy(place.data(), mesh.attributes.data(), place.size());
    }
    if (core::Result<void> submitted = _uploads.submit(*_colours, *batch); !submitted)
        return tl::unexpected(submitted.error());
    return bytes;
}

core::Result<UploadStats> MeshStore::apply(const surface::Delta& delta)
{
    if (core::Result<void> sound = check(delta); !sound)
        return tl::unexpected(sound.error());
    core::Result<Room> room = makeRoom(delta);
    if (!room)
        return tl::unexpected(room.error());
    const core::Result<std::uint64_t> uploaded = upload(delta, *room);
    if (!uploaded) {
        giveBack(std::move(*room));
        return tl::unexpected(uploaded.error());
    }

    const bool fades = _holds && !room->before;
    for (const surface::CellId& id : delta.removed)
        takeAway(id, fades ? shared::kInBoth : 0, !room->before);
    if (room->before) {
        forgetAllBut(StoredCell::kInWanted, false);
        showAll();
    }
    for (std::size_t i = 0; i < delta.added.size(); ++i) {
        _index.emplace(delta.added[i].id, _cells.size());
        _cells.push_back(stored(delta.added[i], room->ranges[i]));
        _cells.back().pictures = fades ? StoredCell::kInWanted : StoredCell::kEverywhere;
    }

    UploadStats stats;
    stats.cellsAdded = delta.added.size();
    stats.cellsRemoved = delta.removed.size();
    stats.uploadedBytes = *uploaded;
    stats.skippedFade = _holds && !fades;
    const core::Result<std::uint64_t> moved = moveOutOfSparseSlab();
    if (!moved)
        return tl::unexpected(moved.error());
    stats.movedBytes = *moved;
    return stats;
}

void MeshStore::hold(bool hold)
{
    _holds = hold;
    if (hold)
        return;
    forgetAllBut(StoredCell::kInWanted, true);
    showAll();
}

void MeshStore::beginTransition()
{
    forgetAllBut(StoredCell::kInWanted | shared::kInPresent, true);
    for (StoredCell& cell : _cells) {
        const bool wasPresent = (cell.pictures & shared::kInPresent) != 0;
        const bool isWanted = (cell.pictures & StoredCell::kInWanted) != 0;
        cell.pictures = (wasPresent ? shared::kInFormer : 0) |
                        (isWanted ? shared::kInPresent | StoredCell::kInWanted : 0);
    }
}

void MeshStore::clear()
{
    for (const StoredCell& cell : _cells)
        retire(cell.range);
    _cells.clear();
    _index.clear();
}

std::uint64_t MeshStore::usedBytes() const
{
    return std::uint64_t{_pool.used()} * kVertexBytes;
}

std::size_t MeshStore::countIn(std::uint32_t pictures) const
{
    return static_cast<std::size_t>(std::ranges::count_if(
        _cells, [&](const StoredCell& cell) { return (cell.pictures & pictures) != 0; }));
}

std::uint64_t MeshStore::fadingBytes() const
{
    std::uint64_t units = 0;
    for (const StoredCell& cell : _cells)
        units += (cell.pictures & StoredCell::kInWanted) == 0 ? cell.range.count : 0;
    return units * kVertexBytes;
}

/// Takes a cell out of what is wanted, and forgets it unless it is part of a keeper.
/// @param retires  false: its range is free already
void MeshStore::takeAway(const surface::CellId& id, std::uint32_t keepers, bool retires)
{
    const auto entry = _index.find(id);
    const std::size_t place = entry->second;
    _index.erase(entry);
    _cells[place].pictures &= ~StoredCell::kInWanted;
    if ((_cells[place].pictures & keepers) != 0)
        return;
    if (retires)
        retire(_cells[place].range);
    erase(place);
}

/// @param keepers  a cell that is part of any of them stays
/// @param retires  false: the ranges of the others are free already
void MeshStore::forgetAllBut(std::uint32_t keepers, bool retires)
{
    for (std::size_t place = 0; place < _cells.size();) {
        if ((_cells[place].pictures & keepers) != 0) {
            ++place;
            continue;
        }
        if (retires)
            retire(_cells[place].range);
        erase(place);
    }
}

void MeshStore::showAll()
{
    for (StoredCell& cell : _cells)
        cell.pictures = StoredCell::kEverywhere;
}

/// Forgets a cell that isn't wanted, or no longer in the index, and leaves its range alone.
void MeshStore::erase(std::size_t place)
{
    if (place + 1 != _cells.size()) {
        _cells[place] = _cells.back();
        if ((_cells[place].pictures & StoredCell::kInWanted) != 0)
            _index[_cells[place].id] = place;
    }
    _cells.pop_back();
}

/// Moves the ranges of a sparse slab into others, so that the slab becomes free. One slab a delta,
/// at most a quarter full, and only when free slabs become few: the cost stays small and even.
core::Result<std::uint64_t> MeshStore::moveOutOfSparseSlab()
{
    if (_pool.freeSlabs() * 2 > _pool.slabs())
        return 0;
    const std::optional<std::uint32_t> slab = _pool.sparsest(_pool.slabUnits() / 4);
    if (!slab)
        return 0;
    core::Result<UploadBatch> batch = _uploads.open(_buffer, 0);
    if (!batch)
        return tl::unexpected(batch.error());
    std::vector<std::pair<StoredCell*, gpu::SlabPool::Range>> moves;
    std::uint32_t found = 0;
    gpu::SlabPool trial = _pool;
    trial.drain(*slab);
    for (StoredCell& cell : _cells) {
        const bool inside = cell.range.count > 0 && cell.range.count <= _pool.slabUnits() &&
                            cell.range.first / _pool.slabUnits() == *slab;
        if (!inside)
            continue;
        const std::optional<gpu::SlabPool::Range> to = trial.allocate(cell.range.count);
        if (!to)
            return 0;
        moves.emplace_back(&cell, *to);
        found += cell.range.count;
        batch->move(
            VkDeviceSize{cell.range.first} * kVertexBytes,
            VkDeviceSize{to->first} * kVertexBytes,
            VkDeviceSize{to->count} * kVertexBytes);
    }
    // Nothing is won by opening another slab, nor while some of it only waits to be recycled.
    if (trial.freeSlabs() != _pool.freeSlabs() || found != _pool.usedIn(*slab))
        return 0;
    if (core::Result<void> submitted = _uploads.submit(_buffer, *batch); !submitted)
        return tl::unexpected(submitted.error());
    if (_colours) {
        core::Result<UploadBatch> colours = _uploads.open(*_colours, 0);
        if (!colours)
            return tl::unexpected(colours.error());
        for (const auto& [cell, to] : moves)
            colours->move(
                VkDeviceSize{cell->range.first} * kColourBytes,
                VkDeviceSize{to.first} * kColourBytes,
                VkDeviceSize{to.count} * kColourBytes);
        if (core::Result<void> moved = _uploads.submit(*_colours, *colours); !moved)
            return tl::unexpected(moved.error());
    }
    _pool = std::move(trial);
    for (const auto& [cell, to] : moves) {
        retire(cell->range);
        cell->range = to;
    }
    return std::uint64_t{found} * kVertexBytes;
}

} // namespace isofront::render
