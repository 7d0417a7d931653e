#include "Rasteriser.h"

#include "Crosshair.h"
#include "CrosshairKernel.h"
#include "TrianglePaint.h"
#include "TriangleParts.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace isofront::voxels {

namespace {

/// The weight of a triangle that only touches a cube: it decides nothing where there is any area.
constexpr float kTrace = 1e-12F;

} // namespace

std::size_t Rasteriser::layersOf(const Placed& placed, const VoxelRange& within)
{
    constexpr std::int64_t kStepsInLayers = kSteps * VoxelGrid::kLayers;
    const std::int64_t lowest =
        std::min({placed.corners[0][2], placed.corners[1][2], placed.corners[2][2]});
    // what only touches a voxel from above counts
    const std::int64_t above = lowest - 1 - within.low[2] * kSteps;
    return static_cast<std::size_t>(
        std::clamp<std::int64_t>(above / kStepsInLayers, 0, VoxelGrid::kTakes - 1));
}

void Rasteriser::add(
    const LatticeModel& model,
    std::uint32_t index,
    const LatticeTriangle& triangle,
    const VoxelRange& within)
{
    const std::array<std::int64_t, 3> area = doubleArea(triangle);
    glm::dvec3 normal(
        static_cast<double>(area[0]), static_cast<double>(area[1]), static_cast<double>(area[2]));
    const double squared = glm::dot(normal, normal);
    if (squared > 0)
        normal /= std::sqrt(squared);
    const std::array<float, 3> direction{
        static_cast<float>(normal.x), static_cast<float>(normal.y), static_cast<float>(normal.z)};

    std::optional<TrianglePaint> paint;
    if (model.model.isColoured())
        paint.emplace(model, index, triangle);
    const auto addTo = [&](auto x, auto y, auto z, const TrianglePart& share) {
        const std::array<std::uint32_t, 3> place{
            static_cast<std::uint32_t>(x - within.low[0]),
            static_cast<std::uint32_t>(y - within.low[1]),
            static_cast<std::uint32_t>(z - within.low[2])};
        const auto weight = static_cast<float>(share.area);
        const float counted = std::max(weight, kTrace);
        WeightedFace part;
        part.area = weight;
        for (std::size_t axis = 0; axis < 3; ++axis)
            part.normal[axis] = counted * direction[axis];
        if (paint) {
            part.colour = paint->at(share.offset, share.area);
            for (float& component : part.colour)
                component *= counted;
        }
        if (!_facesOf.empty()) {
            addToFaces(place, part);
            return;
        }
        const std::uint32_t voxel = _grid.at(place[0], place[1], place[2]);
        addSurface(_grid.surface(voxel), part);
        if (paint)
            addColour(_grid.colour(voxel), part.colour);
    };
    forEachTouched(triangle, within, paint.has_value(), _parts, addTo);
}

void Rasteriser::addToFaces(const std::array<std::uint32_t, 3>& place, const WeightedFace& part)
{
    const auto found = _facesOf.find(packPlace(place[0], place[1], place[2], 0));
    if (found == _facesOf.end())
        return;
    // each face sees what is turned towards it, as large as it looks from there
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const float share = std::abs(part.normal[axis]) / std::max(part.area, kTrace);
        if (share > 0)
            addAttributes(
                found->second->faces[2 * axis + (part.normal[axis] > 0 ? 1U : 0U)],
                scaled(part, share));
    }
}

void Rasteriser::mark(const LatticeTriangle& triangle, const VoxelRange& within)
{
    if (!hasSmallCrosshairs(triangle)) {
        forEachCrosshair(
            triangle, within, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t) {
                _grid.mark(_grid.at(
                    static_cast<std::uint32_t>(x - within.low[0]),
                    static_cast<std::uint32_t>(y - within.low[1]),
                    static_cast<std::uint32_t>(z - within.low[2])));
            });
        return;
    }
    const std::size_t count = findCrosshairs(triangle, within, _hits);
    constexpr std::uint32_t kMask = (1U << kPlaceBits) - 1;
    for (std::size_t i = 0; i < count; ++i) {
        const auto place = static_cast<std::uint32_t>(_hits[i]);
        _grid.mark(
            _grid.at(place & kMask, place >> kPlaceBits & kMask, place >> 2 * kPlaceBits & kMask));
    }
}

/// Goes through the triangles once more, for the voxels whose triangles are turned to different
/// sides.
void Rasteriser::addFaces(
    const LatticeModel& model,
    std::span<const std::uint32_t> triangles,
    const VoxelRange& within,
    VoxelList& list)
{
    constexpr std::uint32_t kBlock = 16; // edge of those that are looked through [voxels]
    constexpr std::uint32_t kBlocks = kChunkEdge / kBlock;
    const auto blockOf = [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return x / kBlock + kBlocks * (y / kBlock + kBlocks * (z / kBlock));
    };
    std::vector<bool> concerned(std::size_t{kBlocks} * kBlocks * kBlocks);
    for (std::uint32_t i = 0; i < list.voxels.size(); ++i) {
        if (!isMixed(list.voxels[i]))
            continue;
        const Voxel voxel{list.voxels[i].place, 0};
        concerned[blockOf(voxel.x(), voxel.y(), voxel.z())] = true;
        list.faces.push_back({i, {}});
    }
    if (list.faces.empty())
        return;
    for (WeightedFaces& faces : list.faces)
        _facesOf.emplace(list.voxels[faces.voxel].order(), &faces);
    for (const std::uint32_t index : triangles) {
        const LatticeTriangle triangle = model.triangle(index);
        const VoxelRange range = intersection(voxelsOf(triangle), within);
        std::array<std::uint32_t, 3> low{};
        std::array<std::uint32_t, 3> high{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis] = static_cast<std::uint32_t>(range.low[axis] - within.low[axis]);
            high[axis] = static_cast<std::uint32_t>(range.high[axis] - within.low[axis] - 1);
        }
        bool isConcerned = false;
        for (std::uint32_t z = low[2] / kBlock; z <= high[2] / kBlock && !isConcerned; ++z)
            for (std::uint32_t y = low[1] / kBlock; y <= high[1] / kBlock && !isConcerned; ++y)
                for (std::uint32_t x = low[0] / kBlock; x <= high[0] / kBlock; ++x)
                    isConcerned = isConcerned || concerned[x + kBlocks * (y + kBlocks * z)];
        if (isConcerned)
            add(model, index, triangle, within);
    }
    _facesOf.clear();
}

/// Gathers the triangles and sorts them by the lowest of the grid's layers that they touch; those
/// of one stay in their order.
void Rasteriser::sort(
    const LatticeModel& model, std::span<const std::uint32_t> triangles, const VoxelRange& within)
{
    _placed.clear();
    _begin.fill(0);
    for (const std::uint32_t index : triangles) {
        const std::array<std::uint32_t, 3>& corners = model.model.triangles[index];
        const Placed& placed = _placed.emplace_back(Placed{
            {model.points[corners[0]], model.points[corners[1]], model.points[corners[2]]}, index});
        ++_begin[layersOf(placed, within) + 1];
    }
    for (std::size_t layers = 0; layers < VoxelGrid::kTakes; ++layers)
        _begin[layers + 1] += _begin[layers];
    _order.resize(_placed.size());
    auto next = _begin;
    for (std::uint32_t i = 0; i < _placed.size(); ++i)
        _order[next[layersOf(_placed[i], within)]++] = i;
}

void Rasteriser::run(
    const LatticeModel& model,
    const std::array<std::uint32_t, 3>& chunk,
    std::span<const std::uint32_t> triangles,
    Separability separability,
    VoxelList& list,
    std::uint64_t& touched)
{
    VoxelRange within;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        within.low[axis] = static_cast<std::int64_t>(chunk[axis]) * kChunkEdge;
        within.high[axis] = within.low[axis] + kChunkEdge;
    }
    const bool coloured = model.model.isColoured();
    _grid.begin(coloured);
    const auto take = [&](std::uint32_t voxel, std::uint32_t place, bool) {
        const WeightedSurface& surface = _grid.surface(voxel);
        list.voxels.push_back({place, surface.normal, surface.area});
        if (coloured)
            list.colours.push_back(_grid.colour(voxel));
    };
    sort(model, triangles, within);
    for (std::uint32_t layers = 0; layers < VoxelGrid::kTakes; ++layers) {
        for (std::uint32_t i = _begin[layers]; i < _begin[layers + 1]; ++i) {
            const Placed& placed = _placed[_order[i]];
            LatticeTriangle triangle{};
            for (std::size_t corner = 0; corner < 3; ++corner)
                for (std::size_t axis = 0; axis < 3; ++axis)
                    triangle[corner][axis] = placed.corners[corner][axis];
            add(model, placed.index, triangle, within);
            // a triangle touches all voxels whose crosshair it meets, so they are there
            mark(triangle, within);
        }
        // those that come touch none of these
        touched += _grid.take(layers, separability == Separability::six, take);
    }
    addFaces(model, triangles, within, list);
}

} // namespace isofront::voxels
