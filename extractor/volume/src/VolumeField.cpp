#include "isofront/volume/VolumeField.h"

#include "Interpolation.h"
#include "MinMaxTree.h"

#include <isofront/core/Assert.h>

#include <array>
#include <utility>

namespace isofront::volume {

using detail::clampedTo;
using detail::mixed;

template <typename T>
VolumeField<T>::VolumeField(glm::ivec3 dimensions, std::shared_ptr<const T[]> voxels)
    : _dimensions(dimensions), _voxels(std::move(voxels))
{
    ISOFRONT_ASSERT(
        dimensions.x >= 1 && dimensions.y >= 1 && dimensions.z >= 1,
        "a volume needs at least one voxel along each axis");
    ISOFRONT_ASSERT(_voxels != nullptr, "a volume needs its voxels");
    _tree = std::make_unique<const detail::MinMaxTree<T>>(_dimensions, _voxels.get());
}

template <typename T>
VolumeField<T>::~VolumeField() = default;

template <typename T>
void VolumeField<T>::sample(const fields::SampleBatch& batch, std::span<float> values) const
{
    ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");

    // First all look-ups of a block, which wait for memory, then its arithmetic, which vectorises.
    constexpr std::size_t kBlock = 64;
    std::array<std::array<double, kBlock>, 8> corner; // all that is read is written before
    std::array<double, kBlock> tx;
    std::array<double, kBlock> ty;
    std::array<double, kBlock> tz;

    const glm::dvec3 limit(_dimensions - 1);
    const glm::ivec3 lastIndex = _dimensions - 1;
    const std::int64_t rowStride = _dimensions.x;
    const std::int64_t sliceStride = rowStride * _dimensions.y;
    const T* const voxels = _voxels.get();

    for (std::size_t begin = 0; begin < batch.size(); begin += kBlock) {
        const std::size_t count = std::min(kBlock, batch.size() - begin);
        for (std::size_t i = 0; i < count; ++i) {
            const double x = clampedTo(0.0, limit.x, batch.x[begin + i]);
            const double y = clampedTo(0.0, limit.y, batch.y[begin + i]);
            const double z = clampedTo(0.0, limit.z, batch.z[begin + i]);
            const int ix = static_cast<int>(x);
            const int iy = static_cast<int>(y);
            const int iz = static_cast<int>(z);
            tx[i] = x - ix;
            ty[i] = y - iy;
            tz[i] = z - iz;
            // On the last plane of an axis the weight is zero: the step must only stay inside.
            const std::int64_t stepX = ix < lastIndex.x ? 1 : 0;
            const std::int64_t stepY = iy < lastIndex.y ? rowStride : 0;
            const std::int64_t stepZ = iz < lastIndex.z ? sliceStride : 0;
            const T* const near = voxels + iz * sliceStride + iy * rowStride + ix;
            const T* const far = near + stepZ;
            corner[0][i] = static_cast<double>(near[0]);
            corner[1][i] = static_cast<double>(near[stepX]);
            corner[2][i] = static_cast<double>(near[stepY]);
            corner[3][i] = static_cast<double>(near[stepY + stepX]);
            corner[4][i] = static_cast<double>(far[0]);
            corner[5][i] = static_cast<double>(far[stepX]);
            corner[6][i] = static_cast<double>(far[stepY]);
            corner[7][i] = static_cast<double>(far[stepY + stepX]);
        }
        float* const out = values.data() + begin;
        for (std::size_t i = 0; i < count; ++i) {
            const double low = mixed<T>(
                mixed<T>(corner[0][i], corner[1][i], tx[i]),
                mixed<T>(corner[2][i], corner[3][i], tx[i]),
                ty[i]);
            const double high = mixed<T>(
                mixed<T>(corner[4][i], corner[5][i], tx[i]),
                mixed<T>(corner[6][i], corner[7][i], tx[i]),
                ty[i]);
            out[i] = static_cast<float>(mixed<T>(low, high, tz[i]));
        }
    }
}

template <typename T>
core::Interval VolumeField<T>::bounds(const core::Box& box, core::Interval /*radius*/) const
{
    return _tree->bounds(box);
}

template <typename T>
double VolumeField<T>::differenceStep(double /*radius*/) const
{
    return 1.0;
}

template <typename T>
std::optional<core::Box> VolumeField<T>::dataBox() const
{
    return core::Box{glm::dvec3(0.0), glm::dvec3(_dimensions - 1)};
}

template <typename T>
std::uint64_t VolumeField<T>::memoryBytes() const
{
    const auto count = static_cast<std::uint64_t>(_dimensions.x) *
                       static_cast<std::uint64_t>(_dimensions.y) *
                       static_cast<std::uint64_t>(_dimensions.z);
    return count * sizeof(T) + _tree->memoryBytes();
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
