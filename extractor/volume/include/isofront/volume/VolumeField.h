#pragma once

#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace isofront::volume {

namespace detail {
template <typename T>
class MinMaxTree;
}

/// A dense volume as a field in index space: voxel (i, j, k) has its centre at (i, j, k).
///
/// A sample is the trilinear interpolation of the eight voxels around it, x first, then y, then z,
/// in double, rounded once to float; at a voxel's centre it is that voxel. A voxel of weight zero
/// has no influence, even if it isn't finite. Points outside the data box are clamped to it (NaN
/// coordinates to its low side).
///
/// The filter radius is ignored: samples are unfiltered at every radius.
///
/// T is one of int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, float and double. A double
/// beyond the range of float is treated as an infinity by `bounds`.
///
/// Cost: two stored values for 512 voxels beside the voxels; sampling doesn't allocate.
/// Thread: any number of threads at once.
template <typename T>
class VolumeField final : public fields::Field {
public:
    /// @param dimensions  voxels along x, y and z, each at least 1 (asserted)
    /// @param voxels      dimensions.x * y * z values, x fastest, then y; not null (asserted)
    VolumeField(glm::ivec3 dimensions, std::shared_ptr<const T[]> voxels);
    ~VolumeField() override;

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override;

    /// From a min/max tree over bricks of 8^3 interpolation cells. An empty box, and one with a
    /// NaN, gives the range of the whole volume. Where a voxel is not finite the interval reaches
    /// to -infinity (NaN counts as outside), and to +infinity if one is +infinity.
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override;
    /// One voxel.
    [[nodiscard]] double differenceStep(double radius) const override;
    /// The box of voxel centres, [0, dimensions - 1].
    [[nodiscard]] std::optional<core::Box> dataBox() const override;

    [[nodiscard]] glm::ivec3 dimensions() const { return _dimensions; }
    /// Bytes of the voxels and of the tree.
    [[nodiscard]] std::uint64_t memoryBytes() const;

private:
    glm::ivec3 _dimensions;
    std::shared_ptr<const T[]> _voxels;
    std::unique_ptr<const detail::MinMaxTree<T>> _tree;
};

extern template class VolumeField<std::int8_t>;
extern template class VolumeField<std::uint8_t>;
extern template class VolumeField<std::int16_t>;
extern template class VolumeField<std::uint16_t>;
extern template class VolumeField<std::int32_t>;
extern template class VolumeField<std::uint32_t>;
extern template class VolumeField<float>;
extern template class VolumeField<double>;

} // namespace isofront::volume
