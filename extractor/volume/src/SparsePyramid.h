#pragma once

#include "MinMaxTree.h"
#include "SparseBounds.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Count.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_set>
#include <vector>

namespace isofront::volume::detail {

/// Makes a level of a sparse volume from the next finer one: node c of it takes [1 4 6 4 1] / 16 of
/// the nodes 2 c - 2 to 2 c + 2 along each axis. Outside its nodes a sparse volume has its
/// background, so there is no border. Where nothing but one value is seen, the level has a tile or
/// its background: it is as sparse as the volume.
///
/// Non-finite values are left out along each axis in turn, and the weights of the others scaled up;
/// where none is left the result is NaN.
template <typename Tree>
class SparseFilter {
public:
    explicit SparseFilter(const Tree& fine) : _fine(fine), _reader(fine) {}

    [[nodiscard]] BrickTree::Ptr run()
    {
        auto coarse = std::make_shared<BrickTree>(toFloat(_fine.background()));
        std::unordered_set<Coord> leaves; // low corners of those to be filtered
        for (auto leaf = _fine.cbeginLeaf(); leaf; ++leaf)
            forLeavesIn(seeing(leaf->getNodeBoundingBox()), [&](const Coord& origin) {
                leaves.insert(origin);
            });
        auto tile = _fine.cbeginValueAll();
        tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) {
            if (*tile == _fine.background())
                continue;
            CoordBBox box;
            tile.getBoundingBox(box);
            const CoordBBox inside = seeingNothingBut(box);
            if (!inside.empty())
                coarse->fill(inside, toFloat(*tile));
            forLeavesIn(seeing(box), [&](const Coord& origin) {
                if (inside.empty() || !inside.isInside(leafBox(origin)))
                    leaves.insert(origin);
            });
        }
        for (const Coord& origin : leaves)
            filterLeaf(origin, *coarse);
        return coarse;
    }

private:
    static constexpr int kEdge = kBlockEdge;
    static constexpr int kSeen = 2 * kEdge + 3; ///< nodes that those of a leaf see along an axis

    static float toFloat(typename Tree::ValueType value)
    {
        return isUsable(value) ? static_cast<float>(value)
                               : std::numeric_limits<float>::quiet_NaN();
    }

    /// The coarse nodes that see a node of the box.
    static CoordBBox seeing(const CoordBBox& box)
    {
        return {(box.min() - Coord(1)) >> 1, (box.max() + Coord(2)) >> 1};
    }
    /// Those that see no other; may be empty.
    static CoordBBox seeingNothingBut(const CoordBBox& box)
    {
        return {(box.min() + Coord(3)) >> 1, (box.max() - Coord(2)) >> 1};
    }
    static CoordBBox leafBox(const Coord& origin) { return CoordBBox::createCube(origin, kEdge); }

    template <typename Visit>
    static void forLeavesIn(const CoordBBox& nodes, const Visit& visit)
    {
        const CoordBBox blocks(nodes.min() >> kBlockBits, nodes.max() >> kBlockBits);
        for (auto block = blocks.begin(); block; ++block)
            visit(*block << kBlockBits);
    }

    static double mean(double a, double b, double c, double d, double e, bool hasGaps)
    {
        if (!hasGaps)
            return a / 16 + b / 4 + c * 0.375 + d / 4 + e / 16;
        constexpr std::array<double, 5> kWeights = {1, 4, 6, 4, 1};
        const std::array<double, 5> values = {a, b, c, d, e};
        double sum = 0;
        double total = 0;
        for (std::size_t i = 0; i < 5; ++i) {
            if (!std::isfinite(values[i]))
                continue;
            sum += kWeights[i] * values[i];
            total += kWeights[i];
        }
        return total > 0 ? sum / total : std::numeric_limits<double>::quiet_NaN();
    }

    /// Filters along one axis: `outer` lines of kSeen values a stride apart become kEdge long.
    static void filterAxis(
        const std::vector<double>& in,
        std::vector<double>& out,
        std::size_t outer,
        std::size_t stride,
        bool hasGaps)
    {
        for (std::size_t o = 0; o < outer; ++o) {
            for (std::size_t j = 0; j < kEdge; ++j) {
                const double* const a = in.data() + (o * kSeen + 2 * j) * stride;
                double* const to = out.data() + (o * kEdge + j) * stride;
                for (std::size_t i = 0; i < stride; ++i)
                    to[i] = mean(
                        a[i],
                        a[stride + i],
                        a[2 * stride + i],
                        a[3 * stride + i],
                        a[4 * stride + i],
                        hasGaps);
            }
        }
    }

    void filterLeaf(const Coord& origin, BrickTree& coarse)
    {
        constexpr std::size_t kLong = kSeen;
        constexpr std::size_t kShort = kEdge;
        _values.resize(kLong * kLong * kLong);
        _alongX.resize(kShort * kLong * kLong);
        _alongY.resize(kShort * kShort * kLong);
        _alongZ.resize(kShort * kShort * kShort);
        const Coord low = (origin << 1) - Coord(2);
        bool hasGaps = false;
        std::size_t next = 0;
        Coord node;
        for (node.x() = low.x(); node.x() < low.x() + kSeen; ++node.x()) {
            for (node.y() = low.y(); node.y() < low.y() + kSeen; ++node.y()) {
                for (node.z() = low.z(); node.z() < low.z() + kSeen; ++node.z()) {
                    const auto value = _reader.getValue(node);
                    hasGaps = hasGaps || !isUsable(value);
                    _values[next++] = isUsable(value) ? static_cast<double>(value)
                                                      : std::numeric_limits<double>::quiet_NaN();
                }
            }
        }
        filterAxis(_values, _alongX, 1, kLong * kLong, hasGaps);
        filterAxis(_alongX, _alongY, kShort, kLong, hasGaps);
        filterAxis(_alongY, _alongZ, kShort * kShort, 1, hasGaps);

        bool isUniform = true;
        for (const double value : _alongZ)
            isUniform = isUniform && value == _alongZ.front();
        if (isUniform) {
            const auto value = static_cast<float>(_alongZ.front());
            if (coarse.probeConstLeaf(origin) != nullptr || coarse.getValue(origin) != value)
                coarse.addTile(1, origin, value, true);
            return;
        }
        float* const out = coarse.touchLeaf(origin)->buffer().data(); // z fastest
        for (std::size_t i = 0; i < _alongZ.size(); ++i)
            out[i] = static_cast<float>(_alongZ[i]);
    }

    const Tree& _fine;
    Reader<Tree> _reader;
    std::vector<double> _values;
    std::vector<double> _alongX;
    std::vector<double> _alongY;
    std::vector<double> _alongZ;
};

/// The Gaussian levels of a sparse volume from g_1 on. Node c of level k lies at 2^k c.
///
/// Thread: any number of readers.
class SparsePyramid {
public:
    struct Level {
        BrickTree::ConstPtr tree;
        double scale = 1; ///< nodes a voxel
        SparseBounds bounds;
    };

    /// The first level whose nodes are as far apart as the box is long.
    static int topOf(const CoordBBox& box)
    {
        const Coord extent = box.max() - box.min();
        int top = 0;
        while ((std::int64_t{1} << top) < std::max({extent.x(), extent.y(), extent.z()}))
            ++top;
        return top;
    }

    /// @param sign  1, or -1 for bounds of the negated values
    /// @param box   within which the volume is sampled
    template <typename Tree>
    SparsePyramid(const Tree& voxels, double sign, const CoordBBox& box)
    {
        const int top = topOf(box);
        _levels.reserve(static_cast<std::size_t>(top));
        for (int level = 1; level <= top; ++level) {
            const BrickTree::ConstPtr tree =
                level == 1 ? SparseFilter<Tree>(voxels).run()
                           : SparseFilter<BrickTree>(*_levels.back().tree).run();
            const Coord low(box.min() >> static_cast<std::size_t>(level));
            const Coord high(
                -((-box.max().x()) >> level),
                -((-box.max().y()) >> level),
                -((-box.max().z()) >> level));
            _levels.push_back(
                {tree, std::ldexp(1.0, -level), SparseBounds(*tree, sign, {low, high})});
        }
    }

    /// @param k  at least 1
    [[nodiscard]] const Level& level(int k) const
    {
        return _levels[static_cast<std::size_t>(k - 1)];
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += openvdb::tools::memUsage(*level.tree, false) + level.bounds.memoryBytes();
        return bytes;
    }

private:
    std::vector<Level> _levels;
};

} // namespace isofront::volume::detail
