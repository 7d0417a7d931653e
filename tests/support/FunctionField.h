#pragma once

#include <isofront/core/Hash.h>
#include <isofront/fields/Field.h>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <utility>

namespace isofront::tests {

/// A field from any function of position and filter radius; its bounds say nothing.
class FunctionField final : public fields::Field {
public:
    using Function = std::function<double(const glm::dvec3&, double radius)>;

    explicit FunctionField(
        Function function, double step = 1e-3, std::optional<core::Box> box = std::nullopt)
        : _function(std::move(function)), _step(step), _box(std::move(box))
    {
    }
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(_function(
                {batch.x[i], batch.y[i], batch.z[i]}, batch.radius.empty() ? 0 : batch.radius[i]));
    }
    [[nodiscard]] core::Interval bounds(const core::Box&, core::Interval) const override
    {
        return {};
    }
    [[nodiscard]] double differenceStep(double) const override { return _step; }
    [[nodiscard]] std::optional<core::Box> dataBox() const override { return _box; }

private:
    Function _function;
    double _step;
    std::optional<core::Box> _box;
};

/// A number in [-1, 1) that depends on every bit of a position and radius: where two cells disagree
/// in a last bit, they disagree wholly.
inline double hashed(const glm::dvec3& p, double radius, std::uint64_t seed)
{
    std::uint64_t hash = core::mixed(seed);
    for (const double value : {p.x, p.y, p.z, radius})
        hash = core::hashCombined(hash, std::bit_cast<std::uint64_t>(value));
    return static_cast<double>(hash >> 11U) * 0x1p-52 - 1.0;
}

inline double sphere(const glm::dvec3& p, const glm::dvec3& centre, double radius)
{
    return radius - glm::distance(p, centre);
}

inline double torus(const glm::dvec3& p, const glm::dvec3& centre, double major, double minor)
{
    const glm::dvec3 q = p - centre;
    return minor - std::hypot(std::hypot(q.x, q.y) - major, q.z);
}

/// A gyroid of so many periods in the unit cube.
inline double gyroid(const glm::dvec3& p, double periods)
{
    const glm::dvec3 q = p * (2 * std::numbers::pi * periods);
    return std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) +
           std::sin(q.z) * std::cos(q.x);
}

} // namespace isofront::tests
