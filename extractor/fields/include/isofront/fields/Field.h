#pragma once

#include <isofront/core/Box.h>

#include <glm/ext/vector_int3_sized.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
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

/// Points of an axis-aligned grid: point (i, j, k) lies at `origin + spacing * (first + (i, j,
/// k))`, computed so, in double. Blocks of one grid share `origin` and `spacing` and differ in
/// `first`.
struct SampleGrid {
    glm::dvec3 origin{0.0}; ///< [field]
    double spacing = 1;     ///< [field], > 0
    glm::i64vec3 first{0};  ///< index of the first point
    glm::i64vec3 count{1};  ///< points along each axis, each >= 0
    double radius = 0;      ///< filter radius of all of them [field], >= 0

    [[nodiscard]] std::size_t size() const
    {
        return static_cast<std::size_t>(count.x * count.y * count.z);
    }
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

    /// Value and gradient together, each as `sample` and `gradient` give it.
    virtual void sampleWithGradient(
        const SampleBatch& batch, std::span<float> values, GradientSpans gradients) const;

    /// The value at each point of a grid, x fastest, then y. A point's value doesn't depend on the
    /// block that it is asked for in; it may differ from that of `sample` by rounding. Faster where
    /// neighbouring samples have work in common, as those of noise have.
    /// @param values  as long as the grid
    virtual void sampleGrid(const SampleGrid& grid, std::span<float> values) const;

    /// True if `attributes` has something to say.
    [[nodiscard]] virtual bool hasAttributes() const { return false; }
    /// One word a point: a colour or a material, whatever the field means by it. Never
    /// interpolated. By default 0.
    /// @param words  as long as the batch
    virtual void attributes(const SampleBatch& batch, std::span<std::uint32_t> words) const;

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
