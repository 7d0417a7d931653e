#pragma once

#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/ChunkTree.h>
#include <isofront/voxels/ChunkView.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <vector>

namespace isofront::tests {

/// Voxels along the edge of a block: scenes for tests are of blocks, sixteen along a chunk's edge,
/// so that a model of many levels has few of them.
inline constexpr std::uint32_t kBlockEdge = 16;

/// A scene of blocks, and the store that it makes. Of each block the first and the last voxel are
/// there. A parent's blocks contain its children's, as voxels do.
class BlockScene {
public:
    using Place = std::array<std::uint32_t, 3>;

    explicit BlockScene(std::uint32_t levels) : _levels(levels) {}

    /// Blocks along the edge of the finest level.
    [[nodiscard]] std::uint32_t size() const { return kBlockEdge << (_levels - 1); }
    void add(std::uint32_t x, std::uint32_t y, std::uint32_t z) { _blocks.insert({z, y, x}); }
    /// A box's surface, `high` not included.
    void addBox(const Place& low, const Place& high)
    {
        for (std::uint32_t z = low[2]; z < high[2]; ++z)
            for (std::uint32_t y = low[1]; y < high[1]; ++y)
                for (std::uint32_t x = low[0]; x < high[0]; ++x)
                    if (x == low[0] || y == low[1] || z == low[2] || x + 1 == high[0] ||
                        y + 1 == high[1] || z + 1 == high[2])
                        add(x, y, z);
    }

    /// Of a world in which a block of the finest level is 1 long.
    [[nodiscard]] std::unique_ptr<voxels::ChunkStore> store() const
    {
        auto store = voxels::memoryStore();
        voxels::StoredModel model;
        model.name = "blocks";
        model.lattice.edge = 1.0 / kBlockEdge;
        model.lattice.levels = _levels;
        model.lattice.resolution = voxels::kChunkEdge << (_levels - 1);
        std::set<Place> blocks = _blocks;
        for (std::uint32_t level = 0; level < _levels; ++level) {
            std::map<Place, std::vector<std::uint32_t>> chunks;
            for (const auto& [z, y, x] : blocks) {
                auto& places = chunks[{z / 16, y / 16, x / 16}];
                for (const std::uint32_t corner : {0U, kBlockEdge - 1})
                    places.push_back(voxels::packPlace(
                        x % 16 * kBlockEdge + corner,
                        y % 16 * kBlockEdge + corner,
                        z % 16 * kBlockEdge + corner,
                        voxels::kAllFaces));
            }
            for (auto& [place, places] : chunks) {
                std::ranges::sort(places);
                voxels::Chunk chunk;
                chunk.key = {level, place[2], place[1], place[0]};
                for (const std::uint32_t voxel : places)
                    chunk.voxels.push_back({voxel, level});
                model.allVoxels += chunk.voxels.size();
                ++model.chunks;
                (void)store->put(std::move(chunk));
            }
            std::set<Place> parents;
            for (const auto& [z, y, x] : blocks)
                parents.insert({z / 2, y / 2, x / 2});
            blocks = std::move(parents);
        }
        (void)store->finish(model);
        return store;
    }

private:
    std::uint32_t _levels;
    std::set<Place> _blocks; ///< z first
};

/// A wall, and a city of `towers` by `towers` blocks of houses behind it, on the ground.
inline BlockScene city(std::uint32_t levels, std::uint32_t towers, bool hasWall)
{
    BlockScene scene(levels);
    const std::uint32_t size = scene.size();
    for (std::uint32_t y = 0; y < size; ++y)
        for (std::uint32_t x = 0; x < size; ++x)
            scene.add(x, y, 0);
    const std::uint32_t pitch = size / (towers + 1);
    for (std::uint32_t j = 0; j < towers; ++j)
        for (std::uint32_t i = 0; i < towers; ++i) {
            const std::uint32_t x = pitch / 2 + i * pitch;
            const std::uint32_t y = pitch + j * pitch;
            const std::uint32_t height = 3 + (7 * i + 5 * j) % (size / 4);
            scene.addBox({x, y, 0}, {x + pitch / 2, y + pitch / 2, height});
        }
    if (hasWall)
        for (std::uint32_t z = 0; z < size; ++z)
            for (std::uint32_t x = 0; x < size; ++x)
                scene.add(x, 0, z);
    return scene;
}

/// A camera for pictures of block scenes.
struct BlockCamera {
    glm::dvec3 eye{0.0};
    glm::dvec3 forward{0, 1, 0};
    double fieldOfView = 1.0;
    int width = 48;
    int height = 36;
    double nearest = 0.01;

    [[nodiscard]] voxels::ChunkView view() const
    {
        return voxels::perspectiveView(
            eye, forward, {0, 0, 1}, fieldOfView, width, height, nearest);
    }
    /// Of length 1 along `forward`.
    [[nodiscard]] glm::dvec3 ray(int x, int y) const
    {
        const glm::dvec3 ahead = glm::normalize(forward);
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
        const glm::dvec3 above = glm::cross(right, ahead);
        const double tangent = std::tan(0.5 * fieldOfView);
        return ahead + (2 * (x + 0.5) / width - 1) * tangent * width / height * right +
               (1 - 2 * (y + 0.5) / height) * tangent * above;
    }
};

/// The blocks of all chunks of a scene, for drawing them often.
class BlockModel {
public:
    struct Chunk {
        std::vector<glm::dvec3> blocks; ///< their low corners [world]
        double edge = 0;                ///< of a block [world]
    };

    BlockModel(const voxels::ChunkTree& tree, const voxels::ChunkStore& store)
        : _chunks(tree.size())
    {
        for (voxels::ChunkIndex i = 0; i < tree.size(); ++i) {
            // of one that can't be read, what the nearest above has in its place
            const voxels::ChunkKey own = tree[i].entry.key;
            voxels::ChunkKey key = own;
            auto read = store.get(key);
            while ((!read || !*read) && key.level + 1 < tree.lattice().levels) {
                key = key.parent();
                read = store.get(key);
            }
            if (!read || !*read)
                continue;
            Chunk& chunk = _chunks[i];
            chunk.edge = tree.voxelEdge(key.level) * kBlockEdge;
            const std::uint32_t part = voxels::kChunkEdge >> (key.level - own.level);
            const auto isIn = [&](std::uint32_t of, std::uint32_t chunkAt, std::uint32_t at) {
                return (chunkAt * voxels::kChunkEdge + at) / part == of;
            };
            for (const voxels::Voxel& voxel : (*read)->voxels)
                if (voxel.x() % kBlockEdge == 0 && voxel.y() % kBlockEdge == 0 &&
                    voxel.z() % kBlockEdge == 0 && isIn(own.x, key.x, voxel.x()) &&
                    isIn(own.y, key.y, voxel.y()) && isIn(own.z, key.z, voxel.z()))
                    chunk.blocks.push_back(
                        chunk.edge * glm::dvec3(
                                         key.x * 16 + voxel.x() / kBlockEdge,
                                         key.y * 16 + voxel.y() / kBlockEdge,
                                         key.z * 16 + voxel.z() / kBlockEdge));
        }
    }
    [[nodiscard]] const Chunk& operator[](voxels::ChunkIndex index) const { return _chunks[index]; }

private:
    std::vector<Chunk> _chunks;
};

/// Draws blocks exactly: each pixel by intersecting its ray with each block that it may meet.
class BlockPicture {
public:
    /// @param model  outlives the picture
    BlockPicture(const BlockModel& model, const BlockCamera& camera)
        : _model(model), _camera(camera), _ahead(glm::normalize(camera.forward)),
          _right(glm::normalize(glm::cross(_ahead, glm::dvec3(0, 0, 1)))),
          _above(glm::cross(_right, _ahead)),
          _scale(0.5 * camera.height / std::tan(0.5 * camera.fieldOfView))
    {
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                _inverse.push_back(1.0 / camera.ray(x, y));
        depth.assign(_inverse.size(), std::numeric_limits<double>::infinity());
        chunk.assign(_inverse.size(), voxels::kNoChunk);
    }

    /// @return whether any pixel passes the depth test, at equal depth too
    bool draw(voxels::ChunkIndex index, bool isTest)
    {
        bool isVisible = false;
        for (const glm::dvec3& block : _model[index].blocks) {
            isVisible |= drawBlock(index, block - _camera.eye, _model[index].edge, isTest);
            if (isVisible && isTest)
                break;
        }
        return isVisible;
    }

    std::vector<double> depth;
    std::vector<voxels::ChunkIndex> chunk; ///< the nearest; of equals the one with the least index

private:
    bool drawBlock(voxels::ChunkIndex index, const glm::dvec3& low, double edge, bool isTest)
    {
        const auto [left, top, right, bottom] = pixelsOf(low, edge);
        const glm::dvec3 high = low + glm::dvec3(edge);
        bool isVisible = false;
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                const auto at = static_cast<std::size_t>(y * _camera.width + x);
                const glm::dvec3 a = low * _inverse[at];
                const glm::dvec3 b = high * _inverse[at];
                const glm::dvec3 in = glm::min(a, b);
                const glm::dvec3 out = glm::max(a, b);
                const double from = std::max({in.x, in.y, in.z, _camera.nearest});
                if (!(from <= std::min({out.x, out.y, out.z})) || from > depth[at])
                    continue;
                isVisible = true;
                if (isTest || (from == depth[at] && chunk[at] < index))
                    continue;
                depth[at] = from;
                chunk[at] = index;
            }
        return isVisible;
    }

    /// Pixels that a block may meet: left, top, right, bottom; none if the first exceeds the last.
    [[nodiscard]] std::array<int, 4> pixelsOf(const glm::dvec3& low, double edge) const
    {
        const glm::dvec3 p(glm::dot(low, _right), glm::dot(low, _above), glm::dot(low, _ahead));
        std::array<double, 4> box{1e9, 1e9, -1e9, -1e9};
        const auto part = [&](unsigned corner, const glm::dvec3& axis) {
            return edge * ((corner & 1U) * axis.x + (corner >> 1U & 1U) * axis.y +
                           (corner >> 2U) * axis.z);
        };
        bool isBehind = true;
        bool isAcross = false;
        for (unsigned corner = 0; corner < 8; ++corner) {
            const double far = p.z + part(corner, _ahead);
            if (far < _camera.nearest) {
                isAcross = true;
                continue;
            }
            isBehind = false;
            const double x = 0.5 * _camera.width + _scale * (p.x + part(corner, _right)) / far;
            const double y = 0.5 * _camera.height - _scale * (p.y + part(corner, _above)) / far;
            box = {
                std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
        }
        if (isBehind)
            return {1, 1, 0, 0};
        if (isAcross)
            return {0, 0, _camera.width - 1, _camera.height - 1};
        const auto pixel = [](double at, int count) {
            return static_cast<int>(std::clamp(std::floor(at), -2.0, count + 1.0));
        };
        return {
            std::max(0, pixel(box[0], _camera.width) - 1),
            std::max(0, pixel(box[1], _camera.height) - 1),
            std::min(_camera.width - 1, pixel(box[2], _camera.width) + 1),
            std::min(_camera.height - 1, pixel(box[3], _camera.height) + 1)};
    }

    const BlockModel& _model;
    BlockCamera _camera;
    glm::dvec3 _ahead;
    glm::dvec3 _right;
    glm::dvec3 _above;
    double _scale;                    ///< [px] at distance 1
    std::vector<glm::dvec3> _inverse; ///< of rays
};

} // namespace isofront::tests
