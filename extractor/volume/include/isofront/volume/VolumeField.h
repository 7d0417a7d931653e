#pragma once

#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace isofront::volume {

/// A dense volume as a field in index space: voxel (i, j, k) has its centre at (i, j, k).
///
/// Unfiltered, a sample is the trilinear interpolation of the eight voxels around it, x first, then
/// y, then z, in double, rounded once to float; at a voxel's centre it is that voxel. A voxel of
/// weight zero has no influence, even if it isn't finite. Points outside the data box are clamped
/// to it (NaN coordinates to its low side).
///
/// Filtered to a radius r [voxels], it is a weighted mean of such interpolations in the levels of a
/// pyramid, each half as fine as the one before: the sum of the volume's bands, whose frequencies
/// are f_k = 0.3 * 2^-k cycles a voxel, with the weights exp(-(f_k r)^2), stretched by 1/64 at
/// both ends so that they end in exactly 1 and 0. Up to r = 0.418 a sample is the unfiltered one to
/// the last bit. A linear function stays as it is at every radius, a constant one to the last bit.
/// Voxels that aren't finite are left out of the coarser levels, as far as they have others.
/// Source: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
/// of detail and applications", section 3.3.
///
/// T is one of int8_t, uint8_t, int16_t, uint16_t, int32_t, uint32_t, float and double. A double
/// beyond the range of float is treated as an infinity by `bounds`, and as not finite by the
/// filter.
///
/// Cost: the voxels and a hundredth more; the first filtered sample builds the pyramid, which takes
/// a fifth to a seventh of the voxels' memory (a fourteenth for double). Levels of 8-bit volumes
/// are kept to a sixteenth of a unit or better, those of 16 bits to a unit or better, others as
/// float. Sampling doesn't allocate otherwise.
/// Thread: any number of threads at once; those that find the pyramid being built wait for it.
template <typename T>
class VolumeField final : public fields::Field {
public:
    /// @param dimensions  voxels along x, y and z, each at least 1 (asserted)
    /// @param voxels      dimensions.x * y * z values, x fastest, then y; not null (asserted)
    VolumeField(glm::ivec3 dimensions, std::shared_ptr<const T[]> voxels);
    ~VolumeField() override;

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override;
    /// Central differences, as by default and with the same bits, in one pass.
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override;
    void sampleWithGradient(
        const fields::SampleBatch& batch,
        std::span<float> values,
        fields::GradientSpans gradients) const override;

    /// From the voxels themselves for small boxes, else from min/max trees over bricks of 8^3
    /// interpolation cells, one for each level that counts at some radius of the interval. An empty
    /// box, and one with a NaN, gives the range of the whole volume. Where a voxel is not finite
    /// the interval reaches to -infinity (NaN counts as outside), and to +infinity if one is
    /// +infinity.
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override;
    /// One voxel, or half the radius if that is more.
    [[nodiscard]] double differenceStep(double radius) const override;
    /// The box of voxel centres, [0, dimensions - 1].
    [[nodiscard]] std::optional<core::Box> dataBox() const override;

    [[nodiscard]] glm::ivec3 dimensions() const;
    /// Bytes of the voxels, of the min/max tree, and of the pyramid once it is there.
    [[nodiscard]] std::uint64_t memoryBytes() const;

private:
    struct Parts;
    std::unique_ptr<Parts> _parts;
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
