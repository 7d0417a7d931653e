#pragma once

#include <isofront/fields/Field.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <span>
#include <utility>

namespace isofront::volume::detail {

/// A field that is solid within a shell, in index space. Where it is filtered the shell is thicker:
/// samples lie about two filter radii apart there, and would miss what is thinner than that.
class ShellField final : public fields::Field {
public:
    /// @param shell      solid within 1.5 voxels of a surface, with values that fall by `voxel` a
    ///                   voxel away from it
    /// @param voxel      [world]
    /// @param mostGrowth how much thicker it may get on either side [voxels]
    ShellField(std::shared_ptr<const fields::Field> shell, double voxel, double mostGrowth)
        : _shell(std::move(shell)), _voxel(voxel), _mostGrowth(mostGrowth)
    {
    }

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        _shell->sample(batch, values);
        grow(batch, values);
    }
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override
    {
        _shell->gradient(batch, gradients);
    }
    void sampleWithGradient(
        const fields::SampleBatch& batch,
        std::span<float> values,
        fields::GradientSpans gradients) const override
    {
        _shell->sampleWithGradient(batch, values, gradients);
        grow(batch, values);
    }
    void sampleGrid(const fields::SampleGrid& grid, std::span<float> values) const override
    {
        _shell->sampleGrid(grid, values);
        const float more = growth(grid.radius);
        for (float& value : values)
            value += more;
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        const core::Interval plain = _shell->bounds(box, radius);
        return {
            double{static_cast<float>(plain.low) + growth(radius.low)},
            double{static_cast<float>(plain.high) + growth(radius.high)}};
    }
    [[nodiscard]] double differenceStep(double radius) const override
    {
        return _shell->differenceStep(radius);
    }
    [[nodiscard]] std::optional<core::Box> dataBox() const override { return _shell->dataBox(); }

private:
    /// The lattice's points are at most 0.87 steps from any place, a step is two radii with the
    /// filter that is usual, and the filter takes 0.2 radii of the 1.5 voxels that there are.
    [[nodiscard]] float growth(double radius) const
    {
        const double voxels = radius > 0.75 ? std::min(2 * radius - 1.5, _mostGrowth) : 0.0;
        return static_cast<float>(_voxel * voxels);
    }
    void grow(const fields::SampleBatch& batch, std::span<float> values) const
    {
        for (std::size_t i = 0; i < batch.radius.size(); ++i)
            values[i] += growth(batch.radius[i]);
    }

    std::shared_ptr<const fields::Field> _shell;
    double _voxel;
    double _mostGrowth;
};

} // namespace isofront::volume::detail
