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

/// Draws blocks exactly: each pixel by intersecting its ray with each block that it may meet.
class BlockPicture {
public:
    /// @param tree, store  outlive the picture
    BlockPicture(
        const voxels::ChunkTree& tree, const voxels::ChunkStore& store, const BlockCamera& camera)
        : _tree(tree), _store(store), _camera(camera)
    {
        for (int y = 0; y < camera.height; ++y)
            for (int x = 0; x < camera.width; ++x)
                _rays.push_back(camera.ray(x, y));
        depth.assign(_rays.size(), std::numeric_limits<double>::infinity());
        chunk.assign(_rays.size(), voxels::kNoChunk);
    }

    /// @return whether any pixel passes the depth test, at equal depth too
    bool draw(voxels::ChunkIndex index, bool isTest)
    {
        const auto read = _store.get(_tree[index].entry.key);
        const voxels::ChunkKey key = _tree[index].entry.key;
        const double edge = _tree.voxelEdge(key.level) * kBlockEdge;
        bool isVisible = false;
        for (const voxels::Voxel& voxel : (*read)->voxels) {
            if (voxel.x() % kBlockEdge != 0 || voxel.y() % kBlockEdge != 0 ||
                voxel.z() % kBlockEdge != 0)
                continue;
            const glm::dvec3 block(
                key.x * 16 + voxel.x() / kBlockEdge,
                key.y * 16 + voxel.y() / kBlockEdge,
                key.z * 16 + voxel.z() / kBlockEdge);
            isVisible |= drawBlock(index, edge * block, edge, isTest);
        }
        return isVisible;
    }

    std::vector<double> depth;
    std::vector<voxels::ChunkIndex> chunk; ///< the nearest; of equals the one with the least index

private:
    bool drawBlock(voxels::ChunkIndex index, const glm::dvec3& low, double edge, bool isTest)
    {
        const auto [left, top, right, bottom] = pixelsOf(low, edge);
        bool isVisible = false;
        for (int y = top; y <= bottom; ++y)
            for (int x = left; x <= right; ++x) {
                const auto at = static_cast<std::size_t>(y * _camera.width + x);
                double from = _camera.nearest;
                double to = std::numeric_limits<double>::infinity();
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const double inverse = 1 / _rays[at][axis];
                    const double a = (low[axis] - _camera.eye[axis]) * inverse;
                    const double b = (low[axis] + edge - _camera.eye[axis]) * inverse;
                    from = std::max(from, std::min(a, b));
                    to = std::min(to, std::max(a, b));
                }
                if (!(from <= to) || from > depth[at])
                    continue;
                isVisible = true;
                if (isTest || (from == depth[at] && chunk[at] < index))
                    continue;
                depth[at] = from;
                chunk[at] = index;
            }
        return isVisible;
    }

    /// Pixels that a block may meet: left, top, right, bottom.
    [[nodiscard]] std::array<int, 4> pixelsOf(const glm::dvec3& low, double edge) const
    {
        const glm::dvec3 ahead = glm::normalize(_camera.forward);
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
        const glm::dvec3 above = glm::cross(right, ahead);
        const double scale = 0.5 * _camera.height / std::tan(0.5 * _camera.fieldOfView);
        std::array<double, 4> box{1e9, 1e9, -1e9, -1e9};
        for (unsigned corner = 0; corner < 8; ++corner) {
            const glm::dvec3 p =
                low + edge * glm::dvec3(corner & 1U, corner >> 1U & 1U, corner >> 2U) - _camera.eye;
            const double far = glm::dot(p, ahead);
            if (far < _camera.nearest)
                return {0, 0, _camera.width - 1, _camera.height - 1};
            const double x = 0.5 * _camera.width + scale * glm::dot(p, right) / far;
            const double y = 0.5 * _camera.height - scale * glm::dot(p, above) / far;
            box = {
                std::min(box[0], x), std::min(box[1], y), std::max(box[2], x), std::max(box[3], y)};
        }
        const auto pixel = [](double at, int count) {
            return static_cast<int>(std::clamp(std::floor(at), -1.0, static_cast<double>(count)));
        };
        return {
            std::max(0, pixel(box[0], _camera.width) - 1),
            std::max(0, pixel(box[1], _camera.height) - 1),
            std::min(_camera.width - 1, pixel(box[2], _camera.width) + 1),
            std::min(_camera.height - 1, pixel(box[3], _camera.height) + 1)};
    }

    const voxels::ChunkTree& _tree;
    const voxels::ChunkStore& _store;
    BlockCamera _camera;
    std::vector<glm::dvec3> _rays;
};

} // namespace isofront::tests
