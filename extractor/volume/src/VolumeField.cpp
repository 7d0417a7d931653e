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

using detail::BlockOf;
using detail::kBlock;

/// Points of a block.
struct Block {
    std::size_t size = 0;
    std::array<BlockOf<double>, 3> coordinate;
    BlockOf<double> step; ///< for gradients
};

/// At which places about a point a field is wanted.
struct Probes {
    bool centre = true;
    bool around = false; ///< one step away along each axis, to either side
};

/// Values at a block's points, then a step above and a step below them along x, y and z.
using Probed = std::array<BlockOf<double>, 7>;

double stepFor(double radius)
{
    return std::max(1.0, 0.5 * radius);
}

/// Interpolates in a grid of voxels or of a level.
template <typename Grid>
void probe(const Grid& grid, const Block& points, const Probes& probes, Probed& out)
{
    std::array<detail::CellPlaces, 3> places;
    for (std::size_t axis = 0; axis < 3; ++axis)
        detail::placeInCells(grid.axes()[axis], points.coordinate[axis], points.size, places[axis]);
    const auto interpolateTo = [&](BlockOf<double>& values,
                                   const detail::CellPlaces& x,
                                   const detail::CellPlaces& y,
                                   const detail::CellPlaces& z) {
        detail::CellCorners corners;
        grid.corners(x, y, z, points.size, corners);
        detail::interpolateCells(corners, x, y, z, points.size, Grid::kGuarded, values);
        grid.decode(points.size, values);
    };
    if (probes.centre)
        interpolateTo(out[0], places[0], places[1], places[2]);
    if (!probes.around)
        return;
    for (std::size_t k = 0; k < 6; ++k) {
        const std::size_t axis = k / 2;
        BlockOf<double> moved;
        for (std::size_t i = 0; i < points.size; ++i)
            moved[i] = points.coordinate[axis][i] + (k % 2 == 0 ? points.step[i] : -points.step[i]);
        detail::CellPlaces place;
        detail::placeInCells(grid.axes()[axis], moved, points.size, place);
        interpolateTo(
            out[k + 1],
            axis == 0 ? place : places[0],
            axis == 1 ? place : places[1],
            axis == 2 ? place : places[2]);
    }
}

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
    void probeFiltered(const Block& points, const double* radius, const Probes& probes, Probed& out)
    {
        std::array<LevelWeights, kBlock> weights;
        int first = top;
        int end = 0;
        for (std::size_t i = 0; i < points.size; ++i) {
            const bool isAsBefore = i > 0 && radius[i] == radius[i - 1];
            weights[i] = isAsBefore ? weights[i - 1] : detail::levelWeights(radius[i], top);
            first = std::min(first, weights[i].first);
            end = std::max(end, weights[i].first + weights[i].count);
        }
        // Level after level, from the finest on, for those points for which it counts.
        for (int level = first; level < end; ++level) {
            Block chosen;
            BlockOf<std::size_t> index;
            for (std::size_t i = 0; i < points.size; ++i) {
                const int place = level - weights[i].first;
                if (place < 0 || place >= weights[i].count)
                    continue;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    chosen.coordinate[axis][chosen.size] = points.coordinate[axis][i];
                chosen.step[chosen.size] = points.step[i];
                index[chosen.size++] = i;
            }
            Probed values;
            if (level == 0)
                probe(grid, chosen, probes, values);
            else
                probe(pyramid().level(level), chosen, probes, values);
            for (std::size_t k = probes.centre ? 0 : 1; k < (probes.around ? 7U : 1U); ++k) {
                for (std::size_t j = 0; j < chosen.size; ++j) {
                    const LevelWeights& own = weights[index[j]];
                    double& total = out[k][index[j]];
                    const auto place = static_cast<std::size_t>(level - own.first);
                    const double part = own.weight[place] * values[k][j];
                    total = place == 0 ? part : total + part; // 0 + x would lose the sign of -0
                }
            }
        }
    }

    /// Values and gradients of a batch, or one of them.
    void evaluate(
        const fields::SampleBatch& batch,
        const Probes& probes,
        float* values,
        const fields::GradientSpans& gradients)
    {
        const std::array<std::span<const double>, 3> given = {batch.x, batch.y, batch.z};
        for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
            Block points;
            points.size = std::min(kBlock, batch.size() - begin);
            for (std::size_t axis = 0; axis < 3; ++axis)
                std::copy_n(
                    given[axis].data() + begin, points.size, points.coordinate[axis].data());
            const double* const radius =
                batch.radius.empty() ? nullptr : batch.radius.data() + begin;
            bool isFiltered = false;
            for (std::size_t i = 0; i < points.size; ++i) {
                points.step[i] = stepFor(radius != nullptr ? radius[i] : 0.0);
                isFiltered = isFiltered || (radius != nullptr && radius[i] > detail::kPlainRadius);
            }
            Probed probed;
            if (isFiltered)
                probeFiltered(points, radius, probes, probed);
            else
                probe(grid, points, probes, probed);

            if (probes.centre)
                for (std::size_t i = 0; i < points.size; ++i)
                    values[begin + i] = static_cast<float>(probed[0][i]);
            if (!probes.around)
                continue;
            const auto difference = [&](std::size_t above, std::size_t i) {
                // Of samples, which are floats.
                return (static_cast<double>(static_cast<float>(probed[above][i])) -
                        static_cast<double>(static_cast<float>(probed[above + 1][i]))) /
                       (2 * points.step[i]);
            };
            for (std::size_t i = 0; i < points.size; ++i) {
                gradients.x[begin + i] = difference(1, i);
                gradients.y[begin + i] = difference(3, i);
                gradients.z[begin + i] = difference(5, i);
            }
        }
    }

    /// A block of points, some of which are filtered.
    void sampleFiltered(const fields::SampleBatch& block, float* out)
    {
        evaluate(block, {.centre = true, .around = false}, out, {});
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
void VolumeField<T>::gradient(
    const fields::SampleBatch& batch, fields::GradientSpans gradients) const
{
    ISOFRONT_ASSERT(gradients.x.size() >= batch.size(), "one gradient for each point");
    _parts->evaluate(batch, {.centre = false, .around = true}, nullptr, gradients);
}

template <typename T>
void VolumeField<T>::sampleWithGradient(
    const fields::SampleBatch& batch,
    std::span<float> values,
    fields::GradientSpans gradients) const
{
    ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");
    _parts->evaluate(batch, {.centre = true, .around = true}, values.data(), gradients);
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
    return stepFor(radius);
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
