#pragma once

#include "MinMaxTree.h"

#include <isofront/core/Box.h>

#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

namespace isofront::volume::detail {

using openvdb::Coord;
using openvdb::CoordBBox;

/// Reads a tree without registering with it, which would lock; safe because the tree never changes.
template <typename Tree>
using Reader = openvdb::tree::ValueAccessor<const Tree, false>;

inline constexpr int kBlockBits = 3; // a leaf of OpenVDB's standard trees has 8^3 voxels
inline constexpr int kBlockEdge = 1 << kBlockBits;

/// Smaller nodes above the leaves than those of OpenVDB's standard trees, which would take more
/// memory than the few bricks, and nodes of coarse levels, that are to be kept.
using BrickTree = openvdb::tree::Tree4<float, 3, 3, 3>::Type;

/// Bounds of a sparse volume. Like MinMaxTree, level 0 has the range of bricks of 8^3 interpolation
/// cells, 9^3 voxels, and every further level that of 2^3 bricks; but the bricks are stored as the
/// voxels of float trees, so that they are as sparse as the volume.
class SparseBounds {
public:
    /// @param sign  1, or -1 for bounds of the negated values
    template <typename Tree>
    SparseBounds(const Tree& tree, double sign, const CoordBBox& box) : _box(box)
    {
        buildFinest(tree, sign);
        // So far that the bricks of the last level along an axis are few enough for any query.
        const int extent = box.extents()[static_cast<std::size_t>(box.maxExtent())];
        while ((extent >> (kBlockBits + static_cast<int>(_levels.size()) - 1)) > kMostBricks - 2)
            _levels.push_back(
                {coarsened(*_levels.back().low, [](float a, float b) { return std::min(a, b); }),
                 coarsened(*_levels.back().high, [](float a, float b) { return std::max(a, b); })});
        const openvdb::Vec3d low = box.min().asVec3d();
        const openvdb::Vec3d high = box.max().asVec3d();
        _all = bounds({{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}});
    }

    /// What holds every sample at the points of the box, clamped to the data box.
    [[nodiscard]] core::Interval bounds(const core::Box& box) const
    {
        if (box.isEmpty())
            return _all;
        Coord first;
        Coord last;
        std::size_t level = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double lowest = _box.min()[axis];
            const double highest = _box.max()[axis];
            const double low = std::clamp(box.low[axis], lowest, highest);
            const double high = std::clamp(box.high[axis], lowest, highest);
            // A point on a voxel plane needs that plane only, and so belongs to either cell.
            const int firstCell = static_cast<int>(std::floor(low));
            const int lastCell = std::max(firstCell, static_cast<int>(std::ceil(high)) - 1);
            first[axis] = firstCell >> kBlockBits;
            last[axis] = lastCell >> kBlockBits;
            while ((last[axis] >> level) - (first[axis] >> level) >= kMostBricks)
                ++level;
        }
        const Level& bricks = _levels[level];
        const Reader<BrickTree> lows(*bricks.low);
        const Reader<BrickTree> highs(*bricks.high);
        float low = std::numeric_limits<float>::infinity();
        float high = -std::numeric_limits<float>::infinity();
        Coord brick;
        for (brick.x() = first.x() >> level; brick.x() <= last.x() >> level; ++brick.x()) {
            for (brick.y() = first.y() >> level; brick.y() <= last.y() >> level; ++brick.y()) {
                for (brick.z() = first.z() >> level; brick.z() <= last.z() >> level; ++brick.z()) {
                    low = std::min(low, lows.getValue(brick));
                    high = std::max(high, highs.getValue(brick));
                }
            }
        }
        return {static_cast<double>(low), static_cast<double>(high)};
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        // on this thread alone: others might wait for what it is building
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += openvdb::tools::memUsage(*level.low, false) +
                     openvdb::tools::memUsage(*level.high, false);
        return bytes;
    }

private:
    /// A query looks at no more bricks than this along an axis; a larger box uses a coarser level.
    static constexpr int kMostBricks = 4;

    struct Level {
        BrickTree::Ptr low;
        BrickTree::Ptr high;
    };

    /// Extremes of the voxels of one block; along the axes in `shared` only of its first ones.
    template <typename Tree>
    static Extremes<typename Tree::ValueType>
    blockExtremes(const Reader<Tree>& reader, double sign, Coord block, Coord shared)
    {
        using Value = typename Tree::ValueType;
        const Coord origin = block << kBlockBits;
        Extremes<Value> found;
        const auto include = [&](Value value) { found.include(static_cast<Value>(sign) * value); };
        const auto* leaf = reader.probeConstLeaf(origin);
        if (leaf == nullptr) {
            include(reader.getValue(origin));
            return found;
        }
        const Value* values = leaf->buffer().data();
        const auto countAlong = [](int isShared) { return isShared != 0 ? 1 : kBlockEdge; };
        for (int x = 0; x < countAlong(shared.x()); ++x)
            for (int y = 0; y < countAlong(shared.y()); ++y)
                for (int z = 0; z < countAlong(shared.z()); ++z)
                    include(values[(x * kBlockEdge + y) * kBlockEdge + z]);
        return found;
    }

    template <typename Tree>
    void buildFinest(const Tree& tree, double sign)
    {
        using Value = typename Tree::ValueType;
        const Reader<Tree> reader(tree);
        const auto storeInto =
            [](Level& level, const CoordBBox& bricks, const core::Interval& range) {
                level.low->fill(bricks, static_cast<float>(range.low));
                level.high->fill(bricks, static_cast<float>(range.high));
            };
        Extremes<Value> background;
        background.include(static_cast<Value>(sign) * tree.background());
        Level level{
            std::make_shared<BrickTree>(static_cast<float>(background.samples().low)),
            std::make_shared<BrickTree>(static_cast<float>(background.samples().high))};

        const auto setBrick = [&](Coord brick) {
            if (level.low->isValueOn(brick))
                return;
            Extremes<Value> found;
            forCorners([&](Coord corner) {
                found.include(blockExtremes(reader, sign, brick + corner, corner));
            });
            level.low->setValueOn(brick, static_cast<float>(found.samples().low));
            level.high->setValueOn(brick, static_cast<float>(found.samples().high));
        };
        for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
            forCorners([&](Coord corner) { setBrick((leaf->origin() >> kBlockBits) - corner); });

        // Tiles, active or not: within them bricks are constant, those on their low sides and
        // across their high sides see the neighbours too.
        auto tile = tree.cbeginValueAll();
        tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) {
            if (*tile == tree.background())
                continue;
            CoordBBox voxels;
            tile.getBoundingBox(voxels);
            const CoordBBox inside(
                voxels.min() >> kBlockBits, (voxels.max() >> kBlockBits) - Coord(1));
            if (!inside.empty()) {
                Extremes<Value> value;
                value.include(static_cast<Value>(sign) * *tile);
                storeInto(level, inside, value.samples());
            }
            const CoordBBox around(inside.min() - Coord(1), inside.max() + Coord(1));
            for (auto brick = around.begin(); brick; ++brick)
                if (!inside.isInside(*brick))
                    setBrick(*brick);
        }
        _levels.push_back(std::move(level));
    }

    /// One half of the next level. The halves are coarsened apart, because their tiles may differ.
    template <typename Combine>
    static BrickTree::Ptr coarsened(const BrickTree& fine, Combine combine)
    {
        auto coarse = std::make_shared<BrickTree>(fine.background());
        const Reader<BrickTree> reader(fine);
        for (auto value = fine.cbeginValueOn(); value; ++value) {
            CoordBBox bricks;
            value.getBoundingBox(bricks);
            if (!value.isVoxelValue()) { // a tile, at least 8^3: whole bricks of the next level
                coarse->fill({bricks.min() >> 1, bricks.max() >> 1}, *value);
                continue;
            }
            const Coord brick = bricks.min() >> 1;
            if (coarse->isValueOn(brick))
                continue;
            float found = reader.getValue(brick << 1);
            forCorners([&](Coord corner) {
                found = combine(found, reader.getValue((brick << 1) + corner));
            });
            coarse->setValueOn(brick, found);
        }
        return coarse;
    }

    template <typename Visit>
    static void forCorners(const Visit& visit)
    {
        for (int i = 0; i < 8; ++i)
            visit(Coord(i & 1, i >> 1 & 1, i >> 2 & 1));
    }

    CoordBBox _box;
    std::vector<Level> _levels; ///< finest first
    core::Interval _all;
};

} // namespace isofront::volume::detail
