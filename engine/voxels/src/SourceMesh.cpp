#include "isofront/voxels/SourceMesh.h"

#include "LatticeExtent.h"
#include "LatticeModel.h"
#include "StoredChunk.h"
#include "TriangleCut.h"
#include "TrianglePaint.h"

#include <isofront/core/Hash.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace isofront::voxels {

namespace {

/// Of the angle up to which the triangles around a corner share a normal: 50 degrees.
constexpr double kCrease = 0.6427876096865394;
/// What of a voxel's face a vertex's colour is the mean of.
constexpr double kColourArea = 0.5;
/// Triangles before and after one around a corner that are asked for their normals: where very many
/// meet, to ask all of them for each would take the square of their number.
constexpr std::ptrdiff_t kMostAround = 64;
/// Triangles around either end of an edge, above which it counts as open, for the same reason.
constexpr std::size_t kMostAtEdge = 256;
/// From the lattice's origin, along each axis [voxels]; what is farther away has no place on it.
constexpr double kFarthest = 2.0 * kMaxResolution;
static_assert(kFarthest * static_cast<double>(kSteps) < 1 << 30);
constexpr std::int64_t kCellSteps = std::int64_t{kSourceSteps} << kSourceCellBits;
constexpr std::int64_t kLatticeSteps = kSteps / std::int64_t{kSourceSteps};
static_assert(kSteps % kSourceSteps == 0 && kCellSteps == 32768);

using List = std::vector<std::uint32_t>;

/// Lists of numbers, one after the other.
struct Lists {
    std::vector<std::uint64_t> begin; ///< of each, and the end
    List entries;

    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t which) const
    {
        return {entries.data() + begin[which], entries.data() + begin[which + 1]};
    }
    [[nodiscard]] std::size_t bytes() const
    {
        return begin.size() * sizeof(std::uint64_t) + entries.size() * sizeof(std::uint32_t);
    }
    /// @param forEach  calls its argument with each list's number and an entry, always in the same
    ///                 order
    template <typename ForEach>
    static Lists of(std::size_t count, const ForEach& forEach)
    {
        Lists lists;
        lists.begin.assign(count + 1, 0);
        forEach([&](std::size_t list, std::uint32_t) { ++lists.begin[list + 1]; });
        for (std::size_t i = 1; i <= count; ++i)
            lists.begin[i] += lists.begin[i - 1];
        lists.entries.resize(lists.begin.back());
        std::vector<std::uint64_t> next(lists.begin.begin(), lists.begin.end() - 1);
        forEach(
            [&](std::size_t list, std::uint32_t entry) { lists.entries[next[list]++] = entry; });
        return lists;
    }
};

/// For each position, the first one at the same place on the lattice.
List welded(const std::vector<std::array<std::int32_t, 3>>& points)
{
    const auto hash = [](const std::array<std::int32_t, 3>& p) {
        const auto word = [](std::int32_t c) {
            return std::uint64_t{static_cast<std::uint32_t>(c)};
        };
        return core::hashCombined(word(p[0]) << 32U | word(p[1]), word(p[2]));
    };
    std::unordered_map<std::array<std::int32_t, 3>, std::uint32_t, decltype(hash)> first(
        points.size(), hash);
    List weld(points.size());
    for (std::uint32_t i = 0; i < points.size(); ++i)
        weld[i] = first.try_emplace(points[i], i).first->second;
    return weld;
}

/// On the grid of sources.
LatticeTriangle onSteps(LatticeTriangle triangle)
{
    for (LatticePoint& corner : triangle)
        for (std::int64_t& place : corner)
            place = floorDivide(place + kLatticeSteps / 2, kLatticeSteps);
    return triangle;
}

glm::dvec3 vectorOf(const LatticePoint& p)
{
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

/// Twice the vector area.
glm::dvec3 areaOf(const LatticeTriangle& triangle)
{
    return vectorOf(doubleArea(triangle));
}

/// Whether a triangle may meet a box, by its plane: less than that it meets the box around it.
bool mayMeet(const LatticeTriangle& triangle, const LatticePoint& low, std::int64_t edge)
{
    const glm::dvec3 normal = areaOf(triangle);
    const double half = 0.5 * static_cast<double>(edge);
    const glm::dvec3 middle = vectorOf(low) + half - vectorOf(triangle[0]);
    const double reach = glm::dot(glm::abs(normal), glm::dvec3(half + 1));
    return std::abs(glm::dot(normal, middle)) <= reach * (1 + 1e-9);
}

/// A vertex as a cell's vertices are told apart.
struct VertexKey {
    std::uint64_t place = 0;
    std::uint64_t look = 0;

    friend bool operator==(const VertexKey&, const VertexKey&) = default;
};
struct VertexHash {
    std::size_t operator()(const VertexKey& key) const
    {
        return core::hashCombined(key.place, key.look);
    }
};

/// The cells of a block while triangles are added.
class CellMaker {
public:
    /// Adds a convex polygon, of which each vertex has its look.
    void add(const CutPolygon& polygon, std::span<const SourceVertex> looks)
    {
        Place place{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto least = std::ranges::min_element(
                polygon, {}, [&](const CutCorner& corner) { return corner.at[axis]; });
            place[axis] = floorDivide(least->at[axis], kCellSteps);
        }
        std::vector<Open>& parts = _cells[{place[2], place[1], place[0]}];
        if (parts.empty() || parts.back().cell.vertices.size() + polygon.size() > kMostVertices) {
            Open fresh;
            fresh.cell.place = glm::uvec3(place[0], place[1], place[2]);
            fresh.cell.part = static_cast<std::uint32_t>(parts.size());
            parts.push_back(std::move(fresh));
        }
        Open& open = parts.back();
        _indices.clear();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            SourceVertex vertex = looks[i];
            for (std::size_t axis = 0; axis < 3; ++axis)
                vertex.place[axis] =
                    static_cast<std::uint16_t>(polygon[i].at[axis] - place[axis] * kCellSteps);
            _indices.push_back(indexOf(open, vertex));
        }
        // those without area stay: they close what a vertex on an edge would leave open
        for (std::size_t i = 2; i < _indices.size(); ++i) {
            const std::array<std::uint16_t, 3> corners{_indices[0], _indices[i - 1], _indices[i]};
            const auto& all = open.cell.vertices;
            const bool isLine = all[corners[0]].place == all[corners[1]].place ||
                                all[corners[1]].place == all[corners[2]].place ||
                                all[corners[2]].place == all[corners[0]].place;
            if (!isLine)
                open.cell.indices.insert(open.cell.indices.end(), corners.begin(), corners.end());
        }
    }

    std::vector<SourceCell> take()
    {
        std::vector<SourceCell> cells;
        for (auto& [place, parts] : _cells)
            for (Open& open : parts)
                if (!open.cell.indices.empty())
                    cells.push_back(std::move(open.cell));
        return cells;
    }

private:
    static constexpr std::size_t kMostVertices = std::numeric_limits<std::uint16_t>::max();
    using Place = std::array<std::int64_t, 3>;
    struct Open {
        SourceCell cell;
        std::unordered_map<VertexKey, std::uint16_t, VertexHash> index;
    };

    static std::uint16_t indexOf(Open& open, const SourceVertex& vertex)
    {
        const VertexKey key{
            vertex.place[0] | std::uint64_t{vertex.place[1]} << 16U |
                std::uint64_t{vertex.place[2]} << 32U,
            vertex.normal | std::uint64_t{vertex.colour} << 32U};
        const auto [entry, isNew] =
            open.index.try_emplace(key, static_cast<std::uint16_t>(open.cell.vertices.size()));
        if (isNew)
            open.cell.vertices.push_back(vertex);
        return entry->second;
    }

    std::map<Place, std::vector<Open>> _cells; ///< by z, y and x
    std::vector<std::uint16_t> _indices;
};

} // namespace

struct SourceMesh::Parts {
    TriangleModel model;
    LatticeModel lattice;
    List weld;
    Lists around;  ///< triangles around the first of equal positions
    Lists byBlock; ///< triangles that may meet a block
    std::uint32_t blockBits = kSourceCellBits;
    glm::uvec3 blocks{1U, 1U, 1U};
    /// Along which everything is cut. One for all: an edge must be cut alike on both its sides.
    std::int64_t step = kCellSteps;
    bool isClosed = false;

    Parts(TriangleModel of, const VoxelLattice& where)
        : model(std::move(of)), lattice(onLattice(model, where)), weld(welded(lattice.points))
    {
    }

    [[nodiscard]] std::size_t indexOf(const glm::uvec3& block) const
    {
        return block.x + std::size_t{blocks.x} * (block.y + std::size_t{blocks.y} * block.z);
    }
    [[nodiscard]] bool isUsable(std::uint32_t triangle) const
    {
        return std::ranges::all_of(model.triangles[triangle], [&](std::uint32_t corner) {
            return corner < model.positions.size() && hasPlace(model.positions[corner]);
        });
    }
    [[nodiscard]] bool hasPlace(const glm::dvec3& position) const
    {
        const glm::dvec3 away = glm::abs(position - lattice.lattice.origin) / lattice.lattice.edge;
        return away.x <= kFarthest && away.y <= kFarthest && away.z <= kFarthest; // no NaN is
    }
    [[nodiscard]] std::int64_t blockSteps() const
    {
        return std::int64_t{kSourceSteps} << blockBits;
    }
    void sort();
    [[nodiscard]] bool hasOpenEdges() const;
    [[nodiscard]] bool encloses() const;
    [[nodiscard]] std::array<glm::dvec3, 3> normalsOf(std::uint32_t triangle) const;
    void addTriangle(
        std::uint32_t triangle,
        const LatticePoint& low,
        const LatticePoint& high,
        CellMaker& cells) const;
};

void SourceMesh::Parts::sort()
{
    const auto count = static_cast<std::uint32_t>(model.triangles.size());
    around = Lists::of(model.positions.size(), [&](const auto& add) {
        for (std::uint32_t i = 0; i < count; ++i)
            if (isUsable(i))
                for (const std::uint32_t corner : model.triangles[i])
                    add(weld[corner], i);
    });
    const std::int64_t edge = blockSteps();
    const std::size_t all = std::size_t{blocks.x} * blocks.y * blocks.z;
    byBlock = Lists::of(all, [&](const auto& add) {
        for (std::uint32_t i = 0; i < count; ++i) {
            if (!isUsable(i))
                continue;
            const LatticeTriangle triangle = onSteps(lattice.triangle(i));
            LatticePoint from{};
            LatticePoint to{};
            std::int64_t met = 1;
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto ends =
                    std::minmax({triangle[0][axis], triangle[1][axis], triangle[2][axis]});
                const auto last = std::int64_t{blocks[static_cast<glm::length_t>(axis)]} - 1;
                from[axis] = std::max<std::int64_t>(floorDivide(ends.first, edge), 0);
                to[axis] = std::min(floorDivide(ends.second, edge), last);
                met *= std::max<std::int64_t>(to[axis] - from[axis] + 1, 0);
            }
            constexpr std::int64_t kFew = 4;
            for (std::int64_t z = from[2]; z <= to[2]; ++z)
                for (std::int64_t y = from[1]; y <= to[1]; ++y)
                    for (std::int64_t x = from[0]; x <= to[0]; ++x)
                        if (met <= kFew || mayMeet(triangle, {x * edge, y * edge, z * edge}, edge))
                            add(indexOf(glm::uvec3(x, y, z)), i);
        }
    });
}

/// Whether some edge has more triangles on one side than on the other.
bool SourceMesh::Parts::hasOpenEdges() const
{
    // of edges that leave `a` for `b`, less those that come from there
    const auto balance = [&](std::uint32_t a, std::uint32_t b) {
        int sum = 0;
        for (const std::uint32_t other : around[a]) {
            const auto& corners = model.triangles[other];
            for (std::size_t i = 0; i < 3; ++i) {
                const std::uint32_t from = weld[corners[i]];
                const std::uint32_t to = weld[corners[(i + 1) % 3]];
                sum += (from == a && to == b ? 1 : 0) - (from == b && to == a ? 1 : 0);
            }
        }
        return sum;
    };
    for (const auto& corners : model.triangles)
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t a = weld[corners[i]];
            const std::uint32_t b = weld[corners[(i + 1) % 3]];
            const bool isFewer = around[a].size() < around[b].size();
            if (a == b)
                continue;
            if (std::min(around[a].size(), around[b].size()) > kMostAtEdge ||
                balance(isFewer ? a : b, isFewer ? b : a) != 0)
                return true;
        }
    return false;
}

/// Whether each part that hangs together has its inside where its triangles say.
bool SourceMesh::Parts::encloses() const
{
    List first(model.positions.size());
    std::iota(first.begin(), first.end(), 0U);
    const auto partOf = [&](std::uint32_t corner) {
        std::uint32_t at = weld[corner];
        while (first[at] != at)
            at = first[at] = first[first[at]];
        return at;
    };
    for (const auto& corners : model.triangles)
        for (const std::uint32_t corner : corners)
            first[partOf(corner)] = partOf(corners[0]);
    std::vector<double> volumes(model.positions.size(), 0);
    for (std::uint32_t i = 0; i < model.triangles.size(); ++i) {
        const std::uint32_t part = partOf(model.triangles[i][0]);
        const auto& middle = lattice.points[part];
        const LatticeTriangle triangle = lattice.triangle(i);
        const glm::dvec3 corner =
            vectorOf(triangle[0]) - glm::dvec3(middle[0], middle[1], middle[2]);
        volumes[part] += glm::dot(corner, areaOf(triangle));
    }
    return std::ranges::none_of(volumes, [](double volume) { return volume < 0; });
}

/// At its corners; of length 1.
std::array<glm::dvec3, 3> SourceMesh::Parts::normalsOf(std::uint32_t triangle) const
{
    const glm::dvec3 own = areaOf(lattice.triangle(triangle));
    std::array<glm::dvec3, 3> normals{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
        glm::dvec3 sum(0);
        const auto all = around[weld[model.triangles[triangle][corner]]];
        const auto self = std::ranges::lower_bound(all, triangle) - all.begin();
        const auto count = static_cast<std::ptrdiff_t>(all.size());
        const auto first = std::max<std::ptrdiff_t>(self - kMostAround, 0);
        const auto last = std::min(self + kMostAround + 1, count);
        for (std::ptrdiff_t i = first; i < last; ++i) {
            const std::uint32_t other = all[static_cast<std::size_t>(i)];
            const glm::dvec3 area = areaOf(lattice.triangle(other));
            if (other == triangle ||
                glm::dot(area, own) > kCrease * glm::length(area) * glm::length(own))
                sum += area;
        }
        const double length = glm::length(sum);
        normals[corner] = length > 0 ? sum / length : glm::dvec3(0, 0, 1);
    }
    return normals;
}

void SourceMesh::Parts::addTriangle(
    std::uint32_t index, const LatticePoint& low, const LatticePoint& high, CellMaker& cells) const
{
    const LatticeTriangle triangle = onSteps(lattice.triangle(index));
    std::optional<TrianglePaint> paint;
    if (model.isColoured())
        paint.emplace(lattice, index, lattice.triangle(index));
    std::optional<std::array<glm::dvec3, 3>> normals; // once something of it is there
    const glm::dvec3 u = vectorOf(triangle[1]) - vectorOf(triangle[0]);
    const glm::dvec3 v = vectorOf(triangle[2]) - vectorOf(triangle[0]);
    const double uu = glm::dot(u, u);
    const double uv = glm::dot(u, v);
    const double vv = glm::dot(v, v);
    const double gram = uu * vv - uv * uv;
    std::vector<SourceVertex> looks;
    const auto lookAt = [&](const LatticePoint& at) {
        const glm::dvec3 offset = vectorOf(at) - vectorOf(triangle[0]);
        const double du = glm::dot(offset, u);
        const double dv = glm::dot(offset, v);
        const double b = gram > 0 ? std::clamp((vv * du - uv * dv) / gram, 0.0, 1.0) : 0;
        const double c = gram > 0 ? std::clamp((uu * dv - uv * du) / gram, 0.0, 1.0 - b) : 0;
        SourceVertex look;
        look.normal =
            packNormal((1 - b - c) * (*normals)[0] + b * (*normals)[1] + c * (*normals)[2]);
        if (paint)
            look.colour =
                colourOf(paint->at(offset / static_cast<double>(kSourceSteps), kColourArea), 1.0F);
        return look;
    };
    cutInto(polygonOf(triangle), low, high, step, [&](const CutPolygon& polygon) {
        if (!normals)
            normals = normalsOf(index);
        looks.clear();
        for (const CutCorner& corner : polygon)
            looks.push_back(lookAt(corner.at));
        cells.add(polygon, looks);
    });
}

SourceMesh::SourceMesh(std::unique_ptr<Parts> parts) : _parts(std::move(parts)) {}
SourceMesh::SourceMesh(SourceMesh&&) noexcept = default;
SourceMesh& SourceMesh::operator=(SourceMesh&&) noexcept = default;
SourceMesh::~SourceMesh() = default;

core::Result<SourceMesh> SourceMesh::create(
    TriangleModel model,
    const VoxelLattice& lattice,
    std::uint32_t blockBits,
    const glm::uvec3& blocks)
{
    if (blockBits < kSourceCellBits || blockBits > 16 || blocks.x < 1 || blocks.y < 1 ||
        blocks.z < 1)
        return core::failure(
            core::ErrorCode::usage,
            "the source of a model is cut into blocks of 2^5 to 2^16 voxels, not 2^" +
                std::to_string(blockBits) + ", and at least one along each axis");
    if (auto failed = checkColours(model))
        return tl::unexpected(*failed);
    auto parts = std::make_unique<Parts>(std::move(model), lattice);
    parts->blockBits = blockBits;
    parts->blocks = blocks;
    if (std::ranges::any_of(
            parts->model.textureOf, [](std::uint32_t texture) { return texture != kNoTexture; }))
        parts->step = std::int64_t{kSourceSteps};
    parts->sort();
    bool areAllUsable = true;
    for (std::uint32_t i = 0; i < parts->model.triangles.size(); ++i)
        areAllUsable = areAllUsable && parts->isUsable(i);
    parts->isClosed = areAllUsable && !parts->hasOpenEdges() && parts->encloses();
    return SourceMesh(std::move(parts));
}

std::vector<SourceCell> SourceMesh::cut(const glm::uvec3& block) const
{
    const Parts& parts = *_parts;
    LatticePoint low{};
    LatticePoint high{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        low[axis] = std::int64_t{block[static_cast<glm::length_t>(axis)]} * parts.blockSteps();
        high[axis] = low[axis] + parts.blockSteps();
    }
    CellMaker cells;
    for (const std::uint32_t triangle : parts.byBlock[parts.indexOf(block)])
        parts.addTriangle(triangle, low, high, cells);
    return cells.take();
}

std::size_t SourceMesh::trianglesNear(const glm::uvec3& block) const
{
    return _parts->byBlock[_parts->indexOf(block)].size();
}

std::size_t SourceMesh::triangles() const
{
    return _parts->model.triangles.size();
}

bool SourceMesh::isClosed() const
{
    return _parts->isClosed;
}

bool SourceMesh::isColoured() const
{
    return _parts->model.isColoured();
}

std::size_t SourceMesh::bytes() const
{
    const TriangleModel& model = _parts->model;
    std::size_t pixels = 0;
    for (const Texture& texture : model.textures)
        pixels += texture.image.rgba.size();
    constexpr std::size_t kPosition =
        sizeof(glm::dvec3) + sizeof(std::array<std::int32_t, 3>) + sizeof(std::uint32_t);
    constexpr std::size_t kTriangle = sizeof(std::array<std::uint32_t, 3>);
    return model.positions.size() * kPosition + model.triangles.size() * kTriangle +
           model.colours.size() * (sizeof(std::uint32_t) + sizeof(std::array<float, 4>)) +
           model.textureCorners.size() *
               (sizeof(std::uint32_t) + sizeof(std::array<glm::vec2, 3>)) +
           4 * pixels + _parts->around.bytes() + _parts->byBlock.bytes();
}

} // namespace isofront::voxels
