#include "isofront/render/HandOver.h"

#include <isofront/core/Assert.h>
#include <isofront/surface/SurfaceCriterion.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::render {

namespace {

constexpr std::uint8_t kAnyLevel = 0xff;
constexpr double kFurtherThanNeeded = 1.25;
/// How far voxels are shown beyond what is theirs [voxels].
constexpr double kOverlap = 4;
/// What is nearer to the eye counts as being so near [voxels].
constexpr double kNearest = 1.0 / 1024;

/// The axis step that meshes have in view, as a share of the largest one that their error allows.
constexpr double kUsualStep = 0.5;

/// Of a cell's mesh, with room for voxels that belong to it but lie beside it.
core::Box boxAround(const extractor::CellMesh& mesh, const hierarchy::Domain& domain, double margin)
{
    std::array<std::uint16_t, 3> low = mesh.vertices.front().position;
    std::array<std::uint16_t, 3> high = low;
    for (const extractor::CellVertex& vertex : mesh.vertices) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = std::min(low[axis], vertex.position[axis]);
            high[axis] = std::max(high[axis], vertex.position[axis]);
        }
    }
    core::Box box;
    for (unsigned corner = 0; corner < 8; ++corner) {
        extractor::CellVertex vertex;
        for (std::size_t axis = 0; axis < 3; ++axis)
            vertex.position[axis] = (corner >> axis & 1U) != 0 ? high[axis] : low[axis];
        box.include(domain.worldFromGrid(mesh.gridPosition(vertex)));
    }
    box.low -= margin;
    box.high += margin;
    return box;
}

double distanceTo(const core::Box& box, const glm::dvec3& eye)
{
    return glm::distance(glm::clamp(eye, box.low, box.high), eye);
}

} // namespace

double voxelFilterFactor(const HandOverSettings& settings)
{
    const double largestStep = settings.meshPixels / surface::kErrorPerStep;
    const double voxel = settings.pixels / kVoxelError;
    return std::max(1.0, kUsualStep * largestStep / voxel);
}

glm::uvec3 BlockGrid::blockAt(const glm::dvec3& place) const
{
    const glm::dvec3 last(count - 1U);
    return glm::uvec3(glm::clamp(glm::floor((place - origin) / edge), glm::dvec3(0.0), last));
}

core::Box BlockGrid::boxOf(const glm::uvec3& block) const
{
    const glm::dvec3 low = origin + edge * glm::dvec3(block);
    return {low, low + edge};
}

core::Result<HandOver> HandOver::create(
    const voxels::ChunkTree& tree,
    const voxels::Chunk* coarsest,
    const hierarchy::Domain& domain,
    int latticeSize,
    const HandOverSettings& settings)
{
    const auto isPositive = [](double value) { return value > 0 && std::isfinite(value); };
    if (!isPositive(settings.pixels) || !isPositive(settings.meshPixels) ||
        !(settings.hysteresis >= 1) || !std::isfinite(settings.hysteresis) || latticeSize < 1)
        return core::failure(
            core::ErrorCode::usage,
            "a hand-over needs bounds on pixels above 0 and a hysteresis of at least 1");
    const bool isRoot =
        tree.size() == 0 || (coarsest != nullptr && voxels::entryOf(*coarsest) == tree[0].entry);
    if (!isRoot)
        return core::failure(
            core::ErrorCode::badData,
            "the hand-over from meshes to voxels needs the model's coarsest chunk, which isn't "
            "there; voxelise again");
    HandOver handOver;
    handOver._settings = settings;
    handOver._domain = domain;
    handOver._latticeSize = latticeSize;
    const voxels::VoxelLattice& lattice = tree.lattice();
    handOver._voxelEdge = lattice.edge;
    BlockGrid& grid = handOver._grid;
    grid.origin = lattice.origin;
    glm::uvec3 voxels(1U, 1U, 1U); // from the first to the last
    if (tree.size() > 0) {
        const voxels::ChunkEntry& root = tree[0].entry;
        for (std::size_t axis = 0; axis < 3; ++axis)
            voxels[axis] = (std::uint32_t{root.high[axis]} + 1U) << root.key.level;
    }
    const std::uint32_t most = std::max({voxels.x, voxels.y, voxels.z});
    if (tree.size() > 0)
        grid.bits = std::max(grid.bits, tree[0].entry.key.level);
    while ((most - 1U) >> grid.bits >= BlockGrid::kMostBlocks)
        ++grid.bits;
    grid.edge = std::ldexp(lattice.edge, static_cast<int>(grid.bits));
    grid.count = ((voxels - 1U) >> grid.bits) + 1U;
    handOver._hasVoxels.assign(grid.size(), false);
    if (tree.size() > 0) {
        // a voxel of the coarsest level is there if one of level 0 is in it; none crosses two
        // blocks
        const std::uint32_t shift = grid.bits - coarsest->key.level;
        for (const voxels::Voxel& voxel : coarsest->voxels)
            handOver._hasVoxels[grid.index(
                {voxel.x() >> shift, voxel.y() >> shift, voxel.z() >> shift})] = true;
    }
    handOver._occupied = static_cast<std::size_t>(
        std::count(handOver._hasVoxels.begin(), handOver._hasVoxels.end(), true));
    handOver._meshBlocks = handOver._occupied;
    handOver._blocks.assign(grid.size(), 0);
    handOver.sum();
    return handOver;
}

core::Result<HandOver> HandOver::createForSource(
    const voxels::ChunkTree& tree, const voxels::Chunk* coarsest, const HandOverSettings& settings)
{
    auto made = create(tree, coarsest, voxelDomain(tree.lattice()), 1, settings);
    if (!made)
        return made;
    made->_hasSource = true;
    made->_source.assign(made->_grid.size(), SourceState::missing);
    std::ranges::fill(made->_blocks, static_cast<std::uint8_t>(kVoxelsInFormer | kVoxelsInPresent));
    made->_meshBlocks = 0;
    made->sum();
    return made;
}

void HandOver::setSource(std::span<const SourceState> states)
{
    ISOFRONT_ASSERT(states.size() == _source.size(), "a state for each block of a source");
    _source.assign(states.begin(), states.end());
}

double HandOver::meshErrorOf(std::size_t block) const
{
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    if (_hasSource && _source[block] != SourceState::nothing)
        return _source[block] == SourceState::there ? 0 : kInfinite;
    const double measured = double(_meshErrors[block]);
    return measured >= 0 ? measured : _hasVoxels[block] ? kInfinite : 0;
}

void HandOver::apply(const surface::Delta& delta)
{
    for (const surface::CellId& id : delta.removed)
        _cells.erase(id);
    const double stretch = _domain.worldFromField.stretch();
    for (const surface::ShownCell& cell : delta.added) {
        const extractor::CellMesh& mesh = *cell.mesh();
        const int level = hierarchy::Diamond(cell.id.spine).level;
        double error = surface::expectedError(level, _latticeSize, _domain);
        if (mesh.stats.errorRms > 0)
            error = std::min(error, double(mesh.stats.errorRms) * stretch);
        _cells[cell.id] = {boxAround(mesh, _domain, _voxelEdge), error};
    }
}

void HandOver::clearMeshes()
{
    _cells.clear();
}

double HandOver::distance(const hierarchy::View& view) const
{
    return kVoxelError * _voxelEdge * view.pixelsPerUnit() / _settings.pixels;
}

double HandOver::reach(const hierarchy::View& view, double coarsening) const
{
    return kFurtherThanNeeded * coarsening * distance(view) + std::sqrt(3.0) * _grid.edge;
}

std::uint8_t HandOver::decided(double voxelError, double meshError, std::uint8_t before) const
{
    const double stay = _settings.hysteresis;
    const bool wereVoxels = before != 0;
    if (voxelError <= _settings.pixels * (wereVoxels ? stay : 1))
        return kVoxelsInPresent;
    if (meshError <= _settings.meshPixels * (wereVoxels ? 1 : stay))
        return 0;
    const bool areBetter =
        wereVoxels ? voxelError <= meshError * stay : voxelError * stay < meshError;
    return areBetter ? kVoxelsInPresent : 0;
}

/// What errors the meshes have in the blocks where they matter.
void HandOver::measureMeshes(const hierarchy::View& view)
{
    const double pixels = view.pixelsPerUnit();
    const double least = kNearest * _voxelEdge;
    const core::Box open{_grid.boxOf(_openLow).low, _grid.boxOf(_openHigh).high};
    for (const auto& [id, cell] : _cells) {
        const glm::dvec3 low = glm::max(cell.box.low, open.low);
        const glm::dvec3 high = glm::min(cell.box.high, open.high);
        if (low.x > high.x || low.y > high.y || low.z > high.z)
            continue;
        const double away = std::max(least, distanceTo(cell.box, view.eye));
        const glm::uvec3 from = _grid.blockAt(low);
        const glm::uvec3 to = _grid.blockAt(high);
        glm::uvec3 block;
        for (block.z = from.z; block.z <= to.z; ++block.z) {
            for (block.y = from.y; block.y <= to.y; ++block.y) {
                for (block.x = from.x; block.x <= to.x; ++block.x) {
                    // no part of the cell in the block is nearer than either of them
                    const double nearest = std::max(away, distanceTo(_grid.boxOf(block), view.eye));
                    float& error = _meshErrors[_grid.index(block)];
                    error = std::max(error, static_cast<float>(cell.error * pixels / nearest));
                }
            }
        }
    }
}

bool HandOver::begin(const hierarchy::View& view, std::span<const VoxelDetail> details)
{
    if (!view.isValid())
        return false;
    const std::size_t size = _grid.size();
    _levels.assign(size, kAnyLevel);
    for (const VoxelDetail& detail : details) {
        const std::uint32_t shift = detail.part.level + 8; // 256 voxels of its level
        const auto first = [&](std::uint32_t place) {
            return std::uint64_t{place} << shift >> _grid.bits;
        };
        const auto last = [&](std::uint32_t place) {
            return (((std::uint64_t{place} + 1) << shift) - 1) >> _grid.bits;
        };
        const voxels::ChunkKey& part = detail.part;
        const auto level = static_cast<std::uint8_t>(detail.level);
        for (std::uint64_t z = first(part.z); z <= last(part.z) && z < _grid.count.z; ++z) {
            for (std::uint64_t y = first(part.y); y <= last(part.y) && y < _grid.count.y; ++y) {
                for (std::uint64_t x = first(part.x); x <= last(part.x) && x < _grid.count.x; ++x) {
                    std::uint8_t& known = _levels[_grid.index(glm::uvec3(x, y, z))];
                    known = known == kAnyLevel ? level : std::max(known, level);
                }
            }
        }
    }

    // Voxels first: where they are good enough, nobody asks for the meshes.
    const double pixels = view.pixelsPerUnit();
    std::array<std::vector<double>, 3> squares; // of distances along the axes
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (std::uint32_t i = 0; i < _grid.count[axis]; ++i) {
            const double low = _grid.origin[axis] + _grid.edge * i;
            const double away = std::clamp(view.eye[axis], low, low + _grid.edge) - view.eye[axis];
            squares[axis].push_back(away * away);
        }
    }
    const auto voxelErrorOf = [&](const glm::uvec3& block, std::size_t index) {
        const int level = _hasVoxels[index] && _levels[index] != kAnyLevel ? _levels[index] : 0;
        const double away = std::max(
            kNearest * _voxelEdge,
            std::sqrt(squares[0][block.x] + squares[1][block.y] + squares[2][block.z]));
        return kVoxelError * std::ldexp(_voxelEdge, level) * pixels / away;
    };
    const auto forEach = [&](const auto& visit) {
        glm::uvec3 block(0U, 0U, 0U);
        std::size_t index = 0;
        for (block.z = 0; block.z < _grid.count.z; ++block.z)
            for (block.y = 0; block.y < _grid.count.y; ++block.y)
                for (block.x = 0; block.x < _grid.count.x; ++block.x, ++index)
                    visit(block, index);
    };
    bool isAnyOpen = false;
    forEach([&](const glm::uvec3& block, std::size_t index) {
        if (voxelErrorOf(block, index) <= _settings.pixels)
            return;
        _openLow = isAnyOpen ? glm::min(_openLow, block) : block;
        _openHigh = isAnyOpen ? glm::max(_openHigh, block) : block;
        isAnyOpen = true;
    });
    _meshErrors.assign(size, -1);
    if (isAnyOpen)
        measureMeshes(view);

    bool hasChanged = false;
    _meshBlocks = 0;
    forEach([&](const glm::uvec3& block, std::size_t index) {
        const bool isOccupied = _hasVoxels[index];
        const auto before = static_cast<std::uint8_t>(_blocks[index] & kVoxelsInPresent);
        const std::uint8_t present =
            decided(voxelErrorOf(block, index), meshErrorOf(index), before);
        const auto both = static_cast<std::uint8_t>(present | (before != 0 ? kVoxelsInFormer : 0));
        hasChanged = hasChanged || both != _blocks[index];
        _blocks[index] = both;
        _meshBlocks += isOccupied && present == 0 ? 1U : 0U;
    });
    if (hasChanged)
        sum();
    return hasChanged;
}

void HandOver::end()
{
    bool hasChanged = false;
    for (std::uint8_t& block : _blocks) {
        const bool areVoxels = (block & kVoxelsInPresent) != 0;
        const auto both =
            static_cast<std::uint8_t>(areVoxels ? kVoxelsInFormer | kVoxelsInPresent : 0);
        hasChanged = hasChanged || both != block;
        block = both;
    }
    if (hasChanged)
        sum();
}

void HandOver::sum()
{
    const glm::uvec3 size = _grid.count + 1U;
    const std::size_t row = size.x;
    const std::size_t slice = row * size.y;
    for (std::size_t picture = 0; picture < 2; ++picture) {
        Sums& sums = _sums[picture];
        sums.assign(slice * size.z, 0);
        std::size_t index = 0;
        for (std::size_t z = 1; z < size.z; ++z) {
            for (std::size_t y = 1; y < size.y; ++y) {
                std::uint32_t inRow = 0;
                for (std::size_t x = 1; x < size.x; ++x, ++index) {
                    inRow += std::uint32_t{_blocks[index]} >> picture & 1U;
                    const std::size_t at = z * slice + y * row + x;
                    sums[at] = inRow + sums[at - row] + sums[at - slice] - sums[at - slice - row];
                }
            }
        }
    }
}

Owners HandOver::ownersOf(const core::Box& box) const
{
    const glm::uvec3 from = _grid.blockAt(box.low);
    const glm::uvec3 to = _grid.blockAt(box.high) + 1U;
    const std::size_t row = _grid.count.x + 1U;
    const std::size_t slice = row * (_grid.count.y + 1U);
    const std::uint32_t all = (to.x - from.x) * (to.y - from.y) * (to.z - from.z);
    Owners owners;
    for (std::size_t picture = 0; picture < 2; ++picture) {
        const Sums& sums = _sums[picture];
        const auto at = [&](std::size_t x, std::size_t y, std::size_t z) {
            return sums[z * slice + y * row + x];
        };
        const std::uint32_t voxels = at(to.x, to.y, to.z) - at(from.x, to.y, to.z) -
                                     at(to.x, from.y, to.z) - at(to.x, to.y, from.z) +
                                     at(from.x, from.y, to.z) + at(from.x, to.y, from.z) +
                                     at(to.x, from.y, from.z) - at(from.x, from.y, from.z);
        const auto bit = static_cast<std::uint8_t>(1U << picture);
        owners.voxels = static_cast<std::uint8_t>(owners.voxels | (voxels > 0 ? bit : 0));
        owners.meshes = static_cast<std::uint8_t>(owners.meshes | (voxels < all ? bit : 0));
    }
    return owners;
}

Owners HandOver::ownersAround(const core::Box& box, std::uint32_t level) const
{
    const double margin = kOverlap * std::ldexp(_voxelEdge, static_cast<int>(level));
    return ownersOf({box.low - margin, box.high + margin});
}

} // namespace isofront::render
