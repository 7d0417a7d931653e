#pragma once

#include "FilterBands.h"
#include "FilterKernel.h"
#include "SparseBounds.h"
#include "SparsePyramid.h"
#include "TrilinearKernel.h"

#include <isofront/core/Assert.h>
#include <isofront/fields/Field.h>

#include <openvdb/openvdb.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <type_traits>
#include <utility>

namespace isofront::volume::detail {

/// The leaves of a tree that have been asked for of late, found faster than by the tree's own
/// accessors, which remember one at a time.
template <typename Tree>
class Leaves {
public:
    using Value = typename Tree::ValueType;

    /// The voxels of 8^3, or the value that all of them have.
    struct Leaf {
        Coord block; ///< coordinates of its voxels, divided by 8
        const Value* values = nullptr;
        Value value;
    };

    explicit Leaves(const Tree& tree) : _reader(tree) {}

    const Leaf& around(const Coord& voxel)
    {
        const Coord block = voxel >> kBlockBits;
        const auto slot =
            static_cast<std::size_t>((block.x() & 3) << 4 | (block.y() & 3) << 2 | (block.z() & 3));
        Leaf& leaf = _leaves[slot];
        const std::uint64_t bit = std::uint64_t{1} << slot;
        if ((_known & bit) == 0 || leaf.block != block) {
            _known |= bit;
            leaf.block = block;
            const auto* found = _reader.probeConstLeaf(voxel);
            leaf.values = found != nullptr ? found->buffer().data() : nullptr;
            if (found == nullptr)
                leaf.value = _reader.getValue(voxel);
        }
        return leaf;
    }

    Value valueAt(const Coord& voxel)
    {
        const Leaf& leaf = around(voxel);
        return leaf.values != nullptr ? leaf.values[offsetOf(voxel)] : leaf.value;
    }

    /// Of a voxel in its leaf.
    static std::size_t offsetOf(const Coord& voxel)
    {
        constexpr int kMask = kBlockEdge - 1;
        return static_cast<std::size_t>(
            ((voxel.x() & kMask) << kBlockBits | (voxel.y() & kMask)) << kBlockBits |
            (voxel.z() & kMask));
    }

private:
    Reader<Tree> _reader;
    std::uint64_t _known = 0; ///< which of the slots are in use
    std::array<Leaf, 64> _leaves;
};

/// A sparse volume as a field in index space; samples and their filter as in VolumeField, but that
/// a volume goes on beyond its box, with its background. The levels are as sparse as the volume.
template <typename Grid>
class GridField final : public fields::Field {
public:
    GridField(typename Grid::ConstPtr grid, double sign, const CoordBBox& box)
        : _grid(std::move(grid)), _sign(sign), _box(box), _bounds(_grid->tree(), sign, box),
          _top(SparsePyramid::topOf(box))
    {
    }

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");
        Block points;
        BlockOf<double> value;
        const std::array<std::span<const double>, 3> given = {batch.x, batch.y, batch.z};
        for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
            points.size = std::min(kBlock, batch.size() - begin);
            for (std::size_t axis = 0; axis < 3; ++axis)
                std::copy_n(
                    given[axis].data() + begin, points.size, points.coordinate[axis].data());
            const auto radii =
                batch.radius.empty() ? batch.radius : batch.radius.subspan(begin, points.size);
            const auto isFiltered = [](double radius) { return radius > kPlainRadius; };
            if (std::ranges::any_of(radii, isFiltered))
                sampleFiltered(points, radii.data(), value);
            else
                sampleTree(_grid->tree(), 1.0, points, nullptr, value);
            for (std::size_t i = 0; i < points.size; ++i)
                values[begin + i] = static_cast<float>(_sign * value[i]);
        }
    }

    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        const core::Interval plain = _bounds.bounds(box);
        const LevelSpan span = levelSpan(radius, _top);
        if (span.end == 1)
            return plain;
        std::array<core::Interval, 32> levels;
        std::size_t count = 0;
        for (int k = span.first; k < span.end; ++k) {
            if (k == 0) {
                levels[count++] = plain;
                continue;
            }
            const SparsePyramid::Level& level = pyramid().level(k);
            levels[count++] = level.bounds.bounds({level.scale * box.low, level.scale * box.high});
        }
        return filteredBounds(radius, _top, std::span(levels).first(count));
    }

    [[nodiscard]] double differenceStep(double radius) const override
    {
        return std::max(1.0, 0.5 * radius);
    }

    [[nodiscard]] std::optional<core::Box> dataBox() const override
    {
        return core::Box{
            glm::dvec3(_box.min().x(), _box.min().y(), _box.min().z()),
            glm::dvec3(_box.max().x(), _box.max().y(), _box.max().z())};
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        return _grid->memUsage() + _bounds.memoryBytes() + _pyramidBytes;
    }

private:
    /// Builds the levels on the first call.
    const SparsePyramid& pyramid() const
    {
        std::call_once(_once, [&] {
            _pyramid = std::make_unique<const SparsePyramid>(_grid->tree(), _sign, _box);
            _pyramidBytes = _pyramid->memoryBytes();
        });
        return *_pyramid;
    }

    /// A block of points, some of which are filtered; without the sign.
    void sampleFiltered(const Block& points, const double* radii, BlockOf<double>& out) const
    {
        BlockWeights weights;
        weighLevels(radii, points.size, _top, weights);
        out.fill(-0.0); // to which adding keeps the sign of zeros
        BlockOf<double> value;
        for (int level = weights.first; level < weights.end; ++level) {
            const double* const row = weights.rows[static_cast<std::size_t>(level)].data();
            if (level == 0)
                sampleTree(_grid->tree(), 1.0, points, row, value);
            else
                sampleTree(
                    *pyramid().level(level).tree, pyramid().level(level).scale, points, row, value);
            for (std::size_t i = 0; i < points.size; ++i)
                if (row[i] > 0)
                    out[i] += row[i] * value[i];
        }
    }

    /// Trilinear interpolation between the nodes of the voxels or of a level.
    /// @param weights  null: all points count; else those with a weight above zero, and values of
    ///                 others mean nothing
    template <typename Tree>
    void sampleTree(
        const Tree& tree,
        double scale,
        const Block& points,
        const double* weights,
        BlockOf<double>& out) const
    {
        std::array<CellPlaces, 3> places;
        for (std::size_t axis = 0; axis < 3; ++axis)
            placeInCells(
                points.coordinate[axis],
                points.size,
                _box.min()[axis],
                _box.max()[axis],
                scale,
                places[axis]);
        CellCorners corners;
        Leaves<Tree> leaves(tree);
        for (std::size_t i = 0; i < points.size; ++i)
            if (weights == nullptr || weights[i] > 0)
                lookUp(
                    leaves,
                    Coord(places[0].cell[i], places[1].cell[i], places[2].cell[i]),
                    i,
                    corners);
        interpolateCells(
            corners,
            places[0],
            places[1],
            places[2],
            points.size,
            std::is_floating_point_v<typename Tree::ValueType>,
            out);
    }

    /// The eight voxels of a cell. Two cells in three lie within one leaf.
    template <typename Tree>
    static void lookUp(Leaves<Tree>& leaves, const Coord& cell, std::size_t i, CellCorners& corners)
    {
        constexpr int kMask = kBlockEdge - 1;
        const bool isWithin =
            (cell.x() & kMask) < kMask && (cell.y() & kMask) < kMask && (cell.z() & kMask) < kMask;
        if (!isWithin) {
            for (int k = 0; k < 8; ++k)
                corners[static_cast<std::size_t>(k)][i] =
                    static_cast<double>(leaves.valueAt(cell.offsetBy(k & 1, k >> 1 & 1, k >> 2)));
            return;
        }
        const auto& leaf = leaves.around(cell);
        if (leaf.values == nullptr) {
            for (BlockOf<double>& corner : corners)
                corner[i] = static_cast<double>(leaf.value);
            return;
        }
        const auto* const first = leaf.values + Leaves<Tree>::offsetOf(cell);
        for (std::size_t k = 0; k < 8; ++k) // z is fastest in a leaf
            corners[k][i] = static_cast<double>(
                first
                    [(k & 1U) * kBlockEdge * kBlockEdge + (k >> 1U & 1U) * kBlockEdge + (k >> 2U)]);
    }

    typename Grid::ConstPtr _grid;
    double _sign;
    CoordBBox _box;
    SparseBounds _bounds;
    int _top;

    mutable std::once_flag _once;
    mutable std::unique_ptr<const SparsePyramid> _pyramid; ///< through pyramid() only
    mutable std::atomic<std::uint64_t> _pyramidBytes = 0;
};

} // namespace isofront::volume::detail
