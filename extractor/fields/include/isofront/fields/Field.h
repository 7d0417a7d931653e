#pragma once

#include <isofront/core/Box.h>

#include <cstddef>
#include <optional>
#include <span>

namespace isofront::fields {

/// Points to sample, as structure of arrays, and how far each is to be low-pass filtered.
struct SampleBatch {
    std::span<const double> x, y, z; ///< [field], all of one length
    /// [field] one filter radius a point, each >= 0; empty means unfiltered everywhere.
    std::span<const double> radius = {};

    [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// Where gradients go, as structure of arrays; as long as the batch [field units / field].
struct GradientSpans {
    std::span<double> x, y, z;
};

/// A scalar function of space that can be low-pass filtered: f(p, r).
///
/// "Field space" is the space in which the field is defined: metres for a terrain, voxel indices
/// for a volume. Solid is where the value is at or above the isovalue.
///
/// A field is immutable. Two calls with the same point and radius give the same bits, wherever the
/// point stands in its batch, on every machine: neighbouring cells rely on it. Values may be
/// non-finite; whoever samples cleans and counts them.
///
/// Thread: any number of threads at once.
class Field {
public:
    Field() = default;
    Field(const Field&) = delete;
    Field& operator=(const Field&) = delete;
    virtual ~Field() = default;

    /// The value at each point.
    /// @param values  as long as the batch
    virtual void sample(const SampleBatch& batch, std::span<float> values) const = 0;

    /// The gradient at each point. By default central differences of six samples along the axes, at
    /// the point's own radius, with `differenceStep()`.
    virtual void gradient(const SampleBatch& batch, GradientSpans gradients) const;

    /// An interval that holds every value that `sample` can give at a point of the box with a
    /// radius in the interval, NaN excepted. Never too narrow; as tight as is cheap. What it
    /// excludes is never sampled.
    [[nodiscard]] virtual core::Interval
    bounds(const core::Box& box, core::Interval radius) const = 0;

    /// Step of the default gradient at a point that is filtered to `radius` [field].
    [[nodiscard]] virtual double differenceStep(double radius) const = 0;

    /// Where the field has data; outside it counts as empty, and a surface there is a cap. Nothing
    /// means everywhere.
    [[nodiscard]] virtual std::optional<core::Box> dataBox() const { return std::nullopt; }
};

} // namespace isofront::fields
