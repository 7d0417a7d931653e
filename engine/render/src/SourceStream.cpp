#include "SourceStream.h"

#include <isofront/voxels/ChunkView.h>
#include <isofront/voxels/Voxel.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <new>
#include <type_traits>
#include <utility>

namespace isofront::render {

namespace {

constexpr std::uint32_t kVertexBytes = sizeof(extractor::CellVertex);
/// Brought in a step; a block may exceed it if it is alone.
constexpr std::uint64_t kStepBytes = std::uint64_t{16} << 20U;
/// Blocks that are being cut, or wait for their frame, for each that can be cut at once.
constexpr std::size_t kAhead = 3;
/// Voxels reach so far beyond the blocks that are theirs, and a little more [voxels]: a block next
/// to the view would show in it.
constexpr double kReach = 5;
/// A colour without it is none: RendererOptions::meshColours.
constexpr std::uint32_t kOpaque = 0xff000000U;

/// How many bits of a lattice's extent tell the voxels of level 0.
std::uint32_t bitsOf(const voxels::VoxelLattice& lattice)
{
    return 8 + lattice.levels - 1;
}

extractor::CellMesh
meshOf(const voxels::SourceCell& cell, std::uint32_t exponent, std::uint32_t bits, bool coloured)
{
    extractor::CellMesh mesh;
    const auto place = [&](std::uint32_t at) {
        return at << (hierarchy::kLatticeBits - bits + voxels::kSourceCellBits);
    };
    mesh.low = {place(cell.place.x), place(cell.place.y), place(cell.place.z)};
    mesh.exponent = static_cast<std::uint8_t>(exponent);
    mesh.indices = cell.indices;
    mesh.vertices.reserve(cell.vertices.size());
    for (const voxels::SourceVertex& vertex : cell.vertices) {
        extractor::CellVertex own;
        own.position = vertex.place;
        own.normal = extractor::octahedral(glm::normalize(voxels::unpackNormal(vertex.normal)));
        mesh.vertices.push_back(own);
        if (coloured)
            mesh.attributes.push_back(vertex.colour | kOpaque);
    }
    return mesh;
}

/// On the device: with its colours, and with its indices filled up to a vertex.
std::uint64_t bytesOf(const extractor::CellMesh& mesh)
{
    const std::uint64_t indices = mesh.indices.size() * sizeof(std::uint16_t) + kVertexBytes;
    return mesh.vertices.size() * kVertexBytes + indices +
           mesh.attributes.size() * sizeof(std::uint32_t);
}

/// What a job makes, or why memory doesn't suffice: nobody could catch it there.
template <typename Make>
std::invoke_result_t<Make> withinMemory(const Make& make)
{
    try {
        return make();
    } catch (const std::bad_alloc&) {
        return core::failure(
            core::ErrorCode::resourceLimit,
            "the mesh that the voxels were made from doesn't fit in memory");
    }
}

} // namespace

hierarchy::Domain voxelDomain(const voxels::VoxelLattice& lattice)
{
    return {
        .origin = lattice.origin,
        .edge = std::ldexp(lattice.edge, static_cast<int>(bitsOf(lattice)))};
}

SourceStream::SourceStream(
    SourceReader read,
    const voxels::VoxelLattice& lattice,
    const BlockGrid& grid,
    std::shared_ptr<core::Jobs> jobs,
    std::uint64_t bytes)
    : _read(std::move(read)), _lattice(lattice), _grid(grid), _jobs(std::move(jobs)),
      _exponent(36 - bitsOf(lattice)), _states(grid.size(), SourceState::missing), _limit(bytes)
{
    static_assert(hierarchy::kGridBits - 10 == 36 && voxels::kSourceSteps == 1U << 10U);
}

SourceStream::~SourceStream()
{
    _stopping.request_stop();
    std::unique_lock lock(_mutex);
    _changed.wait(lock, [this] { return _running == 0; });
}

void SourceStream::submit(std::function<void()> job)
{
    {
        const std::lock_guard lock(_mutex);
        ++_running;
    }
    _jobs->submit([this, job = std::move(job)] {
        if (!_stopping.stop_requested())
            job();
        const std::lock_guard lock(_mutex);
        --_running;
        // under the lock: once it is let go this stream may be gone
        _changed.notify_all();
    });
}

void SourceStream::open()
{
    if (std::exchange(_isOpening, true))
        return;
    submit([this] {
        using Opened = core::Result<std::shared_ptr<const voxels::SourceMesh>>;
        const auto read = [this]() -> Opened {
            const std::stop_token stop = _stopping.get_token();
            auto model = _read(stop);
            if (!model)
                return tl::unexpected(model.error());
            if (stop.stop_requested())
                return core::failure(core::ErrorCode::interrupted, "interrupted");
            auto mesh =
                voxels::SourceMesh::create(std::move(*model), _lattice, _grid.bits, _grid.count);
            if (!mesh)
                return tl::unexpected(mesh.error());
            return std::make_shared<const voxels::SourceMesh>(std::move(*mesh));
        };
        Opened opened = withinMemory(read);
        const std::lock_guard lock(_mutex);
        _opened = std::move(opened);
    });
}

glm::uvec3 SourceStream::placeOf(std::size_t block) const
{
    const std::size_t row = block / _grid.count.x;
    return glm::uvec3(block % _grid.count.x, row % _grid.count.y, row / _grid.count.y);
}

SourceStream::Part SourceStream::partOf(const voxels::SourceMesh& mesh, std::size_t block) const
{
    Part part;
    const std::uint32_t bits = bitsOf(_lattice);
    for (const voxels::SourceCell& cell : mesh.cut(placeOf(block))) {
        auto made = std::make_shared<const extractor::CellMesh>(
            meshOf(cell, _exponent, bits, mesh.isColoured()));
        part.bytes += bytesOf(*made);
        // names of a source's cells mean nothing but themselves
        part.cells.emplace_back(
            surface::CellId{{cell.place.x | cell.part << 16U, cell.place.y, cell.place.z}},
            std::move(made));
    }
    return part;
}

void SourceStream::cut(std::size_t block)
{
    _asked.insert(block);
    submit([this, block, mesh = _mesh] {
        auto part = withinMemory([&]() -> core::Result<Part> { return partOf(*mesh, block); });
        const std::lock_guard lock(_mutex);
        _done.emplace_back(block, std::move(part));
    });
}

void SourceStream::take()
{
    const std::lock_guard lock(_mutex);
    if (_opened) {
        if (*_opened) {
            _mesh = **_opened;
            _isClosed = _mesh->isClosed();
            for (std::size_t block = 0; block < _states.size(); ++block)
                if (_mesh->trianglesNear(placeOf(block)) == 0)
                    _states[block] = SourceState::nothing;
        } else {
            fail(_opened->error());
        }
        _opened.reset();
    }
    for (auto& [block, part] : _done) {
        _asked.erase(block);
        if (!part)
            fail(part.error());
        else if (!_hasFailed)
            _cut.emplace(block, std::move(*part));
    }
    _done.clear();
}

/// What is on the device stays; everywhere else voxels do.
void SourceStream::fail(const core::Error& error)
{
    if (std::exchange(_hasFailed, true))
        return;
    _error = error;
    _mesh.reset();
    _cut.clear();
}

/// Blocks in view whose voxels are too coarse, the nearest first.
std::vector<std::size_t> SourceStream::wanted(const hierarchy::View& view, double distance) const
{
    std::vector<std::pair<double, std::size_t>> near;
    const voxels::ChunkView seen = voxels::perspectiveView(
        view.eye,
        view.forward,
        view.up,
        view.verticalFieldOfView,
        view.width,
        view.height,
        1e-9 * distance);
    const glm::uvec3 from = _grid.blockAt(view.eye - distance);
    const glm::uvec3 to = _grid.blockAt(view.eye + distance);
    glm::uvec3 at;
    for (at.z = from.z; at.z <= to.z; ++at.z) {
        for (at.y = from.y; at.y <= to.y; ++at.y) {
            for (at.x = from.x; at.x <= to.x; ++at.x) {
                const std::size_t block = _grid.index(at);
                if (_states[block] == SourceState::nothing)
                    continue;
                const core::Box box = _grid.boxOf(at);
                const double away =
                    glm::distance(glm::clamp(view.eye, box.low, box.high), view.eye);
                const core::Box reach{
                    box.low - kReach * _lattice.edge, box.high + kReach * _lattice.edge};
                if (away < distance && seen.mayShow(reach))
                    near.emplace_back(away, block);
            }
        }
    }
    std::ranges::sort(near);
    std::vector<std::size_t> blocks;
    for (const auto& [away, block] : near)
        blocks.push_back(block);
    return blocks;
}

/// Takes blocks away that the view doesn't need, until so much is free: at once those that voxels
/// have; the others by and by, when voxels have taken their places. The farthest go first.
void SourceStream::letGo(
    const glm::dvec3& eye,
    const HandOver& owners,
    const std::set<std::size_t>& kept,
    std::uint64_t needed)
{
    constexpr std::uint8_t kVoxelsAlone = kVoxelsInFormer | kVoxelsInPresent;
    std::vector<std::pair<double, std::size_t>> others;
    for (const auto& [block, resident] : _residents)
        if (!kept.contains(block))
            others.emplace_back(glm::distance(_grid.boxOf(placeOf(block)).centre(), eye), block);
    std::ranges::sort(others, std::greater<>());
    std::uint64_t freed = 0;
    for (const auto& [away, block] : others) {
        if (freed >= needed)
            break;
        freed += _residents[block].bytes;
        _states[block] = SourceState::missing;
        if (owners.blocks()[block] == kVoxelsAlone)
            _removed.push_back(block);
    }
}

surface::Delta
SourceStream::update(const hierarchy::View& view, const HandOver& owners, std::uint64_t fadingBytes)
{
    _delta = {};
    _added.clear();
    _removed.clear();
    take();
    if (_hasFailed || !view.isValid()) {
        _isComplete = true;
        return _delta;
    }
    const std::vector<std::size_t> blocks = wanted(view, owners.distance(view));
    _isComplete = true;
    _isFull = false;
    if (!blocks.empty() && !_mesh) {
        open();
        _isComplete = false;
        return _delta;
    }
    std::set<std::size_t> kept; // of the blocks, those that come before one for which is no room
    const std::uint64_t room = _limit > fadingBytes ? _limit - fadingBytes : 0;
    const std::size_t most = kAhead * _jobs->concurrency();
    std::uint64_t bytes = 0;   // of this step
    std::uint64_t waiting = 0; // for a later one
    std::uint64_t missing = 0;
    std::size_t ahead = 0; // that aren't there yet
    std::vector<std::size_t> toCut;
    for (const std::size_t block : blocks) {
        kept.insert(block);
        if (_residents.contains(block)) {
            // one that was to leave, and is needed again before it did
            _states[block] = SourceState::there;
            continue;
        }
        if (++ahead > most) {
            kept.erase(block);
            _isComplete = false;
            continue;
        }
        const auto ready = _cut.find(block);
        // of one that isn't cut nobody knows how large it is: something
        const std::uint64_t own = ready == _cut.end() ? 1 : ready->second.bytes;
        const std::uint64_t taken = _bytes + bytes + waiting + own;
        if (taken > room) {
            missing = taken - room;
            break;
        }
        if (ready == _cut.end()) {
            _isComplete = false;
            if (!_asked.contains(block) && _asked.size() + toCut.size() < most)
                toCut.push_back(block);
            continue;
        }
        if (bytes > 0 && bytes + own > kStepBytes) {
            _isComplete = false;
            waiting += own;
            continue;
        }
        bytes += ready->second.bytes;
        _added.push_back(block);
    }
    // neither what the view doesn't need, nor what comes behind a block that must wait
    std::erase_if(_cut, [&](const auto& entry) { return !kept.contains(entry.first); });
    for (const std::size_t block : toCut)
        cut(block);
    if (missing > 0)
        letGo(view.eye, owners, kept, missing);
    // what leaves makes room by and by; if nothing does, the view needs too much
    const bool isLeaving = std::ranges::any_of(_residents, [&](const auto& resident) {
        return _states[resident.first] == SourceState::missing;
    });
    _isFull = missing > 0 && !isLeaving;
    _isComplete = _isComplete && (missing == 0 || _isFull);
    for (const std::size_t block : _removed)
        for (const surface::CellId& id : _residents[block].ids)
            _delta.removed.push_back(id);
    for (const std::size_t block : _added)
        for (const surface::ShownCell& cell : _cut[block].cells)
            _delta.added.push_back(cell);
    if (!_delta.isEmpty())
        _delta.version = ++_version;
    return _delta;
}

void SourceStream::confirm()
{
    for (const std::size_t block : _removed) {
        _bytes -= _residents[block].bytes;
        _residents.erase(block);
    }
    for (const std::size_t block : _added) {
        Resident& resident = _residents[block];
        resident.bytes = _cut[block].bytes;
        for (const surface::ShownCell& cell : _cut[block].cells)
            resident.ids.push_back(cell.id);
        _bytes += resident.bytes;
        _cut.erase(block);
        _states[block] = SourceState::there;
    }
    _added.clear();
    _removed.clear();
}

void SourceStream::refuse()
{
    _limit = _bytes;
    _added.clear();
    _removed.clear();
}

void SourceStream::wait(const std::stop_token& stop)
{
    std::unique_lock lock(_mutex);
    _changed.wait(lock, stop, [this] { return _opened || !_done.empty() || _running == 0; });
}

bool SourceStream::isWorking() const
{
    const std::lock_guard lock(_mutex);
    return _running > 0 || _opened || !_done.empty();
}

std::optional<core::Error> SourceStream::takeError()
{
    return std::exchange(_error, std::nullopt);
}

std::size_t SourceStream::hostBytes() const
{
    std::size_t bytes = _mesh ? _mesh->bytes() : 0;
    for (const auto& [block, part] : _cut)
        bytes += part.bytes;
    return bytes;
}

} // namespace isofront::render
