#include "isofront/volume/VolumeField.h"

#include "FilterBands.h"
#include "MinMaxTree.h"
#include "Pyramid.h"
#include "VoxelGrid.h"
#include "VoxelKernel.h"

#include <isofront/core/Assert.h>

#include <array>
#include <atomic>
#include <mutex>
#include <type_traits>
#include <utility>

namespace isofront::volume {

using detail::LevelWeights;
using detail::Pyramid;
using detail::VoxelGrid;

namespace {

constexpr std::size_t kBlock = 64;

/// Points of a block, clamped to the volume.
struct Block {
    std::array<double, kBlock> x;
    std::array<double, kBlock> y;
    std::array<double, kBlock> z;
};

} // namespace

template <typename T>
struct VolumeField<T>::Parts {
    Parts(const glm::ivec3& dimensions, std::shared_ptr<const T[]> owned)
        : voxels(std::move(owned)), grid(dimensions, voxels.get()), tree(grid),
          top(detail::topLevel(dimensions))
    {
    }

    /// Builds the levels on the first call.
    const Pyramid<T>& pyramid()
    {
        std::call_once(once, [&] {
            built = std::make_unique<const Pyramid<T>>(grid, tree.all());
            pyramidBytes = built->memoryBytes();
        });
        return *built;
    }

    /// A block of points, some of which are filtered.
    void sampleFiltered(const fields::SampleBatch& block, float* out)
    {
        const std::size_t count = block.size();
        std::array<LevelWeights, kBlock> weights;
        int first = top;
        int end = 0;
        Block points;
        const glm::dvec3 limit(grid.size() - 1);
        for (std::size_t i = 0; i < count; ++i) {
            weights[i] = detail::levelWeights(block.radius[i], top);
            first = std::min(first, weights[i].first);
            end = std::max(end, weights[i].first + weights[i].count);
            points.x[i] = detail::clampedTo(0.0, limit.x, block.x[i]);
            points.y[i] = detail::clampedTo(0.0, limit.y, block.y[i]);
            points.z[i] = detail::clampedTo(0.0, limit.z, block.z[i]);
        }
        // Level after level, from the finest on, for those points for which it counts.
        std::array<double, kBlock> sum;
        for (int level = first; level < end; ++level) {
            Block chosen;
            std::array<std::size_t, kBlock> index;
            std::array<double, kBlock> value;
            std::size_t size = 0;
            for (std::size_t i = 0; i < count; ++i) {
                const int place = level - weights[i].first;
                if (place < 0 || place >= weights[i].count)
                    continue;
                chosen.x[size] = points.x[i];
                chosen.y[size] = points.y[i];
                chosen.z[size] = points.z[i];
                index[size++] = i;
            }
            if (level == 0)
                grid.sample(chosen.x.data(), chosen.y.data(), chosen.z.data(), size, value.data());
            else
                pyramid().level(level).sample(
                    chosen.x.data(), chosen.y.data(), chosen.z.data(), size, value.data());
            for (std::size_t k = 0; k < size; ++k) {
                const LevelWeights& own = weights[index[k]];
                double& total = sum[index[k]];
                const auto place = static_cast<std::size_t>(level - own.first);
                const double part = own.weight[place] * value[k];
                total = place == 0 ? part : total + part; // 0 + x would lose the sign of -0
            }
        }
        for (std::size_t i = 0; i < count; ++i)
            out[i] = static_cast<float>(sum[i]);
    }

    [[nodiscard]] core::Interval plainBounds(const core::Box& box) const
    {
        const glm::dvec3 limit(grid.size() - 1);
        glm::ivec3 first;
        glm::ivec3 last;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double low = detail::clampedTo(0.0, limit[axis], box.low[axis]);
            const double high = detail::clampedTo(0.0, limit[axis], box.high[axis]);
            // A point on a voxel plane needs that plane only, and so belongs to either cell.
            first[axis] = static_cast<int>(low);
            last[axis] = std::max(first[axis], static_cast<int>(std::ceil(high)) - 1);
        }
        return tree.extremes(grid, first, last).samples();
    }

    std::shared_ptr<const T[]> voxels;
    VoxelGrid<T> grid;
    detail::MinMaxTree<VoxelGrid<T>> tree;
    int top;

    std::once_flag once;
    std::unique_ptr<const Pyramid<T>> built; ///< to be reached through pyramid() only
    std::atomic<std::uint64_t> pyramidBytes = 0;
};

template <typename T>
VolumeField<T>::VolumeField(glm::ivec3 dimensions, std::shared_ptr<const T[]> voxels)
{
    ISOFRONT_ASSERT(
        dimensions.x >= 1 && dimensions.y >= 1 && dimensions.z >= 1,
        "a volume needs at least one voxel along each axis");
    ISOFRONT_ASSERT(voxels != nullptr, "a volume needs its voxels");
    _parts = std::make_unique<Parts>(dimensions, std::move(voxels));
}

template <typename T>
VolumeField<T>::~VolumeField() = default;

template <typename T>
void VolumeField<T>::sample(const fields::SampleBatch& batch, std::span<float> values) const
{
    ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");
    const auto isFiltered = [](double radius) { return radius > detail::kPlainRadius; };
    const auto samplePlain = [&](std::size_t begin, std::size_t count) {
        const double* x = batch.x.data() + begin;
        const double* y = batch.y.data() + begin;
        const double* z = batch.z.data() + begin;
        float* out = values.data() + begin;
        if constexpr (sizeof(T) <= 2 || std::is_same_v<T, float>)
            if (detail::sampleVoxels(
                    _parts->grid.size(), _parts->voxels.get(), x, y, z, count, out))
                return;
        for (std::size_t first = 0; first < count; first += kBlock)
            _parts->grid.sample(
                x + first, y + first, z + first, std::min(kBlock, count - first), out + first);
    };
    if (batch.radius.empty()) {
        samplePlain(0, batch.size());
        return;
    }
    for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
        const std::size_t count = std::min(kBlock, batch.size() - begin);
        if (std::ranges::none_of(batch.radius.subspan(begin, count), isFiltered))
            samplePlain(begin, count);
        else
            _parts->sampleFiltered(
                {batch.x.subspan(begin, count),
                 batch.y.subspan(begin, count),
                 batch.z.subspan(begin, count),
                 batch.radius.subspan(begin, count)},
                values.data() + begin);
    }
}

template <typename T>
core::Interval VolumeField<T>::bounds(const core::Box& box, core::Interval radius) const
{
    const bool isAll = box.isEmpty();
    const core::Interval plain = isAll ? _parts->tree.all().samples() : _parts->plainBounds(box);
    const detail::LevelSpan span = detail::levelSpan(radius, _parts->top);
    if (span.end == 1)
        return plain;
    const Pyramid<T>& pyramid = _parts->pyramid();
    std::array<core::Interval, 32> levels;
    std::size_t count = 0;
    for (int level = span.first; level < span.end; ++level) {
        if (level == 0)
            levels[count++] = plain;
        else
            levels[count++] =
                isAll ? pyramid.level(level).bounds() : pyramid.level(level).bounds(box);
    }
    return detail::filteredBounds(radius, _parts->top, std::span(levels).first(count));
}

template <typename T>
double VolumeField<T>::differenceStep(double radius) const
{
    return std::max(1.0, 0.5 * radius);
}

template <typename T>
std::optional<core::Box> VolumeField<T>::dataBox() const
{
    return core::Box{glm::dvec3(0.0), glm::dvec3(_parts->grid.size() - 1)};
}

template <typename T>
glm::ivec3 VolumeField<T>::dimensions() const
{
    return _parts->grid.size();
}

template <typename T>
std::uint64_t VolumeField<T>::memoryBytes() const
{
    const glm::ivec3& size = _parts->grid.size();
    const auto count = static_cast<std::uint64_t>(size.x) * static_cast<std::uint64_t>(size.y) *
                       static_cast<std::uint64_t>(size.z);
    return count * sizeof(T) + _parts->tree.memoryBytes() + _parts->pyramidBytes;
}

template class VolumeField<std::int8_t>;
template class VolumeField<std::uint8_t>;
template class VolumeField<std::int16_t>;
template class VolumeField<std::uint16_t>;
template class VolumeField<std::int32_t>;
template class VolumeField<std::uint32_t>;
template class VolumeField<float>;
template class VolumeField<double>;

} // namespace isofront::volume
