#include "isofront/volume/VolumeField.h"

#include "FilterBands.h"
#include "FilterKernel.h"
#include "Interpolation.h"
#include "MinMaxTree.h"
#include "Pyramid.h"
#include "TrilinearKernel.h"
#include "VoxelGrid.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <mutex>
#include <utility>

namespace isofront::volume {

using detail::Probed;
using detail::Pyramid;
using detail::VoxelGrid;

namespace {

using detail::BlockOf;
using detail::kBlock;

double stepFor(double radius)
{
    return std::max(1.0, 0.5 * radius);
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
    void probeFiltered(
        const detail::Block& points, const double* radii, const detail::Probes& probes, Probed& out)
    {
        detail::BlockWeights weights;
        detail::weighLevels(radii, points.size, top, weights);
        for (BlockOf<double>& values : out)
            values.fill(-0.0); // to which adding keeps the sign of zeros
        // From the finest level on.
        for (int level = weights.first; level < weights.end; ++level)
            detail::addProbed(
                level == 0 ? grid.nodes() : pyramid().level(level).nodes(),
                points,
                probes,
                weights.rows[static_cast<std::size_t>(level)],
                out);
    }

    /// Values and gradients of a batch, or one of them; null are those not wanted.
    void evaluate(
        const fields::SampleBatch& batch, float* values, const fields::GradientSpans* gradients)
    {
        const detail::Probes probes{.centre = values != nullptr, .around = gradients != nullptr};
        const std::array<std::span<const double>, 3> given = {batch.x, batch.y, batch.z};
        detail::Block points;
        Probed probed;
        for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
            points.size = std::min(kBlock, batch.size() - begin);
            for (std::size_t axis = 0; axis < 3; ++axis)
                std::copy_n(
                    given[axis].data() + begin, points.size, points.coordinate[axis].data());
            const auto radii =
                batch.radius.empty() ? batch.radius : batch.radius.subspan(begin, points.size);
            if (probes.around)
                for (std::size_t i = 0; i < points.size; ++i)
                    points.step[i] = stepFor(radii.empty() ? 0.0 : radii[i]);
            const auto isFiltered = [](double radius) { return radius > detail::kPlainRadius; };
            if (std::ranges::any_of(radii, isFiltered))
                probeFiltered(points, radii.data(), probes, probed);
            else
                detail::probe(grid.nodes(), points, probes, probed);

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
                gradients->x[begin + i] = difference(1, i);
                gradients->y[begin + i] = difference(3, i);
                gradients->z[begin + i] = difference(5, i);
            }
        }
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
    _parts->evaluate(batch, values.data(), nullptr);
}

template <typename T>
void VolumeField<T>::gradient(
    const fields::SampleBatch& batch, fields::GradientSpans gradients) const
{
    ISOFRONT_ASSERT(gradients.x.size() >= batch.size(), "one gradient for each point");
    _parts->evaluate(batch, nullptr, &gradients);
}

template <typename T>
void VolumeField<T>::sampleWithGradient(
    const fields::SampleBatch& batch,
    std::span<float> values,
    fields::GradientSpans gradients) const
{
    ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");
    _parts->evaluate(batch, values.data(), &gradients);
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
