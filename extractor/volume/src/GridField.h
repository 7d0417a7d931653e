#pragma once

#include "FilterBands.h"
#include "Interpolation.h"
#include "SparseBounds.h"
#include "SparsePyramid.h"

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
#include <utility>

namespace isofront::volume::detail {

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
        std::array<double, kBlock> value;
        for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
            const std::size_t count = std::min(kBlock, batch.size() - begin);
            const fields::SampleBatch block{
                batch.x.subspan(begin, count),
                batch.y.subspan(begin, count),
                batch.z.subspan(begin, count),
                batch.radius.empty() ? batch.radius : batch.radius.subspan(begin, count)};
            const auto isFiltered = [](double radius) { return radius > kPlainRadius; };
            if (std::ranges::any_of(block.radius, isFiltered))
                sampleFiltered(block, value.data());
            else
                sampleTree(_grid->tree(), 1.0, block, value.data());
            for (std::size_t i = 0; i < count; ++i)
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
    static constexpr std::size_t kBlock = 64;

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
    void sampleFiltered(const fields::SampleBatch& block, double* out) const
    {
        const std::size_t count = block.size();
        std::array<LevelWeights, kBlock> weights;
        int first = _top;
        int end = 0;
        for (std::size_t i = 0; i < count; ++i) {
            weights[i] = levelWeights(block.radius[i], _top);
            first = std::min(first, weights[i].first);
            end = std::max(end, weights[i].first + weights[i].count);
        }
        for (int level = first; level < end; ++level) {
            std::array<double, kBlock> x;
            std::array<double, kBlock> y;
            std::array<double, kBlock> z;
            std::array<double, kBlock> value;
            std::array<std::size_t, kBlock> index;
            std::size_t size = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const int place = level - weights[i].first;
                if (place < 0 || place >= weights[i].count)
                    continue;
                x[size] = block.x[i];
                y[size] = block.y[i];
                z[size] = block.z[i];
                index[size++] = i;
            }
            const fields::SampleBatch chosen{
                std::span(x).first(size), std::span(y).first(size), std::span(z).first(size)};
            if (level == 0)
                sampleTree(_grid->tree(), 1.0, chosen, value.data());
            else
                sampleTree(
                    *pyramid().level(level).tree,
                    pyramid().level(level).scale,
                    chosen,
                    value.data());
            for (std::size_t j = 0; j < size; ++j) {
                const LevelWeights& own = weights[index[j]];
                double& total = out[index[j]];
                const auto place = static_cast<std::size_t>(level - own.first);
                const double part = own.weight[place] * value[j];
                total = place == 0 ? part : total + part; // 0 + x would lose the sign of -0
            }
        }
    }

    /// Trilinear interpolation between the nodes of the voxels or of a level.
    template <typename Tree>
    void
    sampleTree(const Tree& tree, double scale, const fields::SampleBatch& block, double* out) const
    {
        using Value = typename Tree::ValueType;
        const Reader<Tree> reader(tree);
        const openvdb::Vec3d low = _box.min().asVec3d();
        const openvdb::Vec3d high = _box.max().asVec3d();
        std::array<double, 8> corner{}; // z fastest, as in a leaf
        for (std::size_t i = 0; i < block.size(); ++i) {
            const double x = scale * clampedTo(low.x(), high.x(), block.x[i]);
            const double y = scale * clampedTo(low.y(), high.y(), block.y[i]);
            const double z = scale * clampedTo(low.z(), high.z(), block.z[i]);
            const Coord cell(floored(x), floored(y), floored(z));
            gather(reader, cell, corner);
            const double tx = x - cell.x();
            const double ty = y - cell.y();
            const double tz = z - cell.z();
            const double near = mixed<Value>(
                mixed<Value>(corner[0], corner[4], tx), mixed<Value>(corner[2], corner[6], tx), ty);
            const double far = mixed<Value>(
                mixed<Value>(corner[1], corner[5], tx), mixed<Value>(corner[3], corner[7], tx), ty);
            out[i] = mixed<Value>(near, far, tz);
        }
    }

    static int floored(double coordinate)
    {
        const int truncated = static_cast<int>(coordinate);
        return truncated > coordinate ? truncated - 1 : truncated;
    }

    /// The eight voxels of a cell. Two cells in three lie within one leaf.
    template <typename Tree>
    static void gather(const Reader<Tree>& reader, Coord cell, std::array<double, 8>& corner)
    {
        constexpr int kMask = kBlockEdge - 1;
        const int x = cell.x() & kMask;
        const int y = cell.y() & kMask;
        const int z = cell.z() & kMask;
        if (x < kMask && y < kMask && z < kMask) {
            const auto* leaf = reader.probeConstLeaf(cell);
            if (leaf == nullptr) {
                corner.fill(static_cast<double>(reader.getValue(cell)));
                return;
            }
            constexpr int kRow = kBlockEdge;
            constexpr int kSlice = kBlockEdge * kBlockEdge;
            const auto* first = leaf->buffer().data() + x * kSlice + y * kRow + z;
            corner = {
                static_cast<double>(first[0]),
                static_cast<double>(first[1]),
                static_cast<double>(first[kRow]),
                static_cast<double>(first[kRow + 1]),
                static_cast<double>(first[kSlice]),
                static_cast<double>(first[kSlice + 1]),
                static_cast<double>(first[kSlice + kRow]),
                static_cast<double>(first[kSlice + kRow + 1])};
            return;
        }
        for (std::size_t i = 0; i < 8; ++i)
            corner[i] = static_cast<double>(reader.getValue(cell.offsetBy(
                static_cast<int>(i >> 2U & 1U),
                static_cast<int>(i >> 1U & 1U),
                static_cast<int>(i & 1U))));
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
