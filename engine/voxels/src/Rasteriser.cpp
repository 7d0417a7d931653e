#include "Rasteriser.h"

#include "Crosshair.h"
#include "CrosshairKernel.h"
#include "LinearColour.h"
#include "TriangleParts.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <optional>

namespace isofront::voxels {

namespace {

/// The weight of a triangle that only touches a cube: it decides nothing where there is any area.
constexpr float kTrace = 1e-12F;

/// How a triangle is coloured: by the colours of its corners and by its texture.
class TrianglePaint {
public:
    TrianglePaint(const LatticeModel& model, std::uint32_t index, const LatticeTriangle& triangle)
        : _u(side(triangle, 1)), _v(side(triangle, 2)), _uu(glm::dot(_u, _u)),
          _uv(glm::dot(_u, _v)), _vv(glm::dot(_v, _v)), _gram(_uu * _vv - _uv * _uv)
    {
        const TriangleModel& triangles = model.model;
        if (!model.colours.empty())
            for (std::size_t corner = 0; corner < 3; ++corner)
                _colours[corner] = model.colours[triangles.triangles[index][corner]];
        if (triangles.textureOf.empty() || triangles.textureOf[index] == kNoTexture)
            return;
        _texture = &model.textures[triangles.textureOf[index]];
        for (std::size_t corner = 0; corner < 3; ++corner)
            _places[corner] = glm::dvec2(triangles.textureCorners[index][corner]);
        const glm::dvec2 s = _places[1] - _places[0];
        const glm::dvec2 t = _places[2] - _places[0];
        const double ratio = _gram > 0 ? std::abs(s.x * t.y - s.y * t.x) / std::sqrt(_gram) : 0;
        _pixelsPerArea = std::isfinite(ratio) ? ratio * _texture->pixels() : 0;
    }

    /// The colour of a piece; linear, weighted by opacity.
    /// @param offset  of its centroid from the first corner [voxels]
    [[nodiscard]] std::array<float, 4> at(const glm::dvec3& offset, double area) const
    {
        // barycentric coordinates of the centroid: colours are linear in a triangle
        const double du = glm::dot(offset, _u);
        const double dv = glm::dot(offset, _v);
        const double second = _gram > 0 ? std::clamp((_vv * du - _uv * dv) / _gram, 0.0, 1.0) : 0;
        const double third =
            _gram > 0 ? std::clamp((_uu * dv - _uv * du) / _gram, 0.0, 1.0 - second) : 0;
        const auto b = static_cast<float>(second);
        const auto c = static_cast<float>(third);
        const float a = 1 - b - c;
        std::array<float, 4> colour{};
        for (std::size_t i = 0; i < 4; ++i)
            colour[i] = a * _colours[0][i] + b * _colours[1][i] + c * _colours[2][i];
        if (_texture == nullptr)
            return colour;
        const glm::dvec2 place =
            (1 - second - third) * _places[0] + second * _places[1] + third * _places[2];
        const std::array<float, 4> pixel = _texture->at(place, area * _pixelsPerArea);
        for (std::size_t i = 0; i < 4; ++i)
            colour[i] *= pixel[i];
        return colour;
    }

private:
    /// From the first corner to another [voxels].
    static glm::dvec3 side(const LatticeTriangle& triangle, std::size_t to)
    {
        const auto along = [&](std::size_t axis) {
            return static_cast<double>(triangle[to][axis] - triangle[0][axis]) /
                   static_cast<double>(kSteps);
        };
        return {along(0), along(1), along(2)};
    }

    glm::dvec3 _u;
    glm::dvec3 _v;
    double _uu;
    double _uv;
    double _vv;
    double _gram;
    std::array<std::array<float, 4>, 3> _colours{{{1, 1, 1, 1}, {1, 1, 1, 1}, {1, 1, 1, 1}}};
    const MipMap* _texture = nullptr;
    std::array<glm::dvec2, 3> _places{};
    double _pixelsPerArea = 0; ///< of the texture, in a voxel's face
};

} // namespace

LatticeTriangle LatticeModel::triangle(std::uint32_t index) const
{
    LatticeTriangle corners;
    for (std::size_t corner = 0; corner < 3; ++corner)
        for (std::size_t axis = 0; axis < 3; ++axis)
            corners[corner][axis] = points[model.triangles[index][corner]][axis];
    return corners;
}

LatticeModel onLattice(const TriangleModel& model, const VoxelLattice& lattice)
{
    LatticeModel result{model, lattice, {}, {}, {}};
    const double scale = static_cast<double>(kSteps) / lattice.edge;
    result.points.reserve(model.positions.size());
    for (const glm::dvec3& position : model.positions) {
        std::array<std::int32_t, 3> point{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double place = std::round((position[axis] - lattice.origin[axis]) * scale);
            // what is not finite, or far away, belongs to no triangle that counts
            if (std::abs(place) < 1 << 30)
                point[axis] = static_cast<std::int32_t>(place);
        }
        result.points.push_back(point);
    }
    const std::array<float, 256> linear = linearOfCodes();
    result.colours.reserve(model.colours.size());
    for (const std::uint32_t colour : model.colours) {
        const float opacity = static_cast<float>(colour >> 24U) / 255.0F;
        result.colours.push_back(
            {opacity * linear[colour & 0xffU],
             opacity * linear[colour >> 8U & 0xffU],
             opacity * linear[colour >> 16U & 0xffU],
             opacity});
    }
    result.textures.reserve(model.textures.size());
    for (const Texture& texture : model.textures)
        result.textures.emplace_back(texture);
    return result;
}

void Rasteriser::add(const LatticeModel& model, std::uint32_t index, const VoxelRange& within)
{
    const LatticeTriangle triangle = model.triangle(index);
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
        addSurface(_grid.voxel(voxel), part);
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
    _hits.clear();
    if (hasSmallCrosshairs(triangle))
        addCrosshairs(triangle, within, _hits);
    else
        forEachCrosshair(
            triangle, within, [&](std::int64_t x, std::int64_t y, std::int64_t z, std::size_t) {
                _hits.push_back(
                    {static_cast<std::int32_t>(x - within.low[0]),
                     static_cast<std::int32_t>(y - within.low[1]),
                     static_cast<std::int32_t>(z - within.low[2])});
            });
    for (const RangePlace& hit : _hits)
        _grid.mark(
            static_cast<std::uint32_t>(hit[0]),
            static_cast<std::uint32_t>(hit[1]),
            static_cast<std::uint32_t>(hit[2]));
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
        const VoxelRange range = intersection(voxelsOf(model.triangle(index)), within);
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
            add(model, index, within);
    }
    _facesOf.clear();
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
    _grid.clear(coloured);
    for (const std::uint32_t index : triangles) {
        add(model, index, within);
        // a triangle touches all voxels whose crosshair it meets, so they are there
        mark(model.triangle(index), within);
    }
    touched += _grid.size();
    list.voxels.reserve(_grid.size());
    _grid.forEachInOrder(separability == Separability::six, [&](std::uint32_t voxel) {
        list.voxels.push_back(_grid.voxel(voxel));
        if (coloured)
            list.colours.push_back(_grid.colour(voxel));
    });
    addFaces(model, triangles, within, list);
}

} // namespace isofront::voxels
