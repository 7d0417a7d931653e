#pragma once

#include "isofront/elevation/HeightGrid.h"

#include <isofront/fields/Field.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace isofront::elevation {

class HeightPyramid;

/// A landscape of heights as a field: `h(x, y) - z`, in metres, z up; solid is where it is at or
/// above 0.
///
/// Between posts heights are interpolated by Catmull-Rom splines, first along x, then along y, in
/// double: the surface goes through every post and has no creases. Beyond the border posts heights
/// continue in a straight line; points outside the raster are clamped to it (NaN to its low side).
///
/// The filter radius chooses among Gaussian levels of the raster. Level k has every 2^k-th post,
/// low passed by the binomial filter [1 4 6 4 1] / 16 with odd reflection at the border, and
///
///     h(p, r) = sum_k c_k(r) G_k(p),  c_k = w(f_k r) - w(f_(k-1) r),  w(x) = exp(-x^2),
///
/// with f_k = 0.3 * 2^-k / spacing and weight 1 for the last level. This is the Laplacian pyramid,
/// summed by levels instead of bands: the weights add up to 1 and none is negative, so that at
/// radius 0 the heights are the raster's own, and a plane stays a plane at any radius. w is 1 for x
/// below 1/64 and 0 from 3 on, so that few levels are looked up. Where the spacing differs between
/// the axes, f_k takes the geometric mean.
///
/// Source: Burt and Adelson, "The Laplacian pyramid as a compact image code" (1983); Scholz, Bender
/// and Dachsbacher, section 3.3, for the weights. Differs: node-aligned levels; cubic
/// interpolation.
///
/// Cost: 4/3 of the raster as floats. Sampling doesn't allocate. Thread: any number at once.
class ElevationField final : public fields::Field {
public:
    /// @param grid   at least 2 x 2 finite heights, spacings above 0 (asserted)
    /// @param reach  how far the data box reaches above the highest post and below the lowest [m]
    ElevationField(HeightGrid grid, double reach);
    ~ElevationField() override;

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override;
    /// Analytic; it leaves out how the radius changes from place to place.
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override;
    void sampleWithGradient(
        const fields::SampleBatch& batch,
        std::span<float> values,
        fields::GradientSpans gradients) const override;
    /// From trees of the least and greatest height, one for each level of the pyramid.
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override;
    /// A quarter of the spacing of posts.
    [[nodiscard]] double differenceStep(double radius) const override;
    /// The raster from its first to its last post, `reach` higher and lower than its posts.
    [[nodiscard]] std::optional<core::Box> dataBox() const override { return _dataBox; }

    [[nodiscard]] std::uint64_t memoryBytes() const;

private:
    std::unique_ptr<const HeightPyramid> _pyramid;
    core::Box _dataBox;
};

} // namespace isofront::elevation
