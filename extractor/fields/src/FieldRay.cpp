#include <isofront/fields/FieldRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

namespace isofront::fields {
namespace {

/// How many parts an interval is sampled in.
constexpr std::size_t kParts = 16;

using Interval = std::pair<double, double>;

/// The first of the parts of an interval at whose ends the field is on different sides.
std::optional<Interval> firstChange(
    const Field& field,
    const FieldRay& ray,
    const FieldRaySettings& settings,
    const Interval& interval)
{
    std::array<double, kParts + 1> t{};
    std::array<double, kParts + 1> x{};
    std::array<double, kParts + 1> y{};
    std::array<double, kParts + 1> z{};
    std::array<double, kParts + 1> radius{};
    std::array<float, kParts + 1> values{};
    radius.fill(settings.radius);
    for (std::size_t i = 0; i <= kParts; ++i) {
        const double share = static_cast<double>(i) / kParts;
        t[i] = i == kParts ? interval.second
                           : interval.first + share * (interval.second - interval.first);
        const glm::dvec3 point = ray.at(t[i]);
        x[i] = point.x;
        y[i] = point.y;
        z[i] = point.z;
    }
    field.sample({x, y, z, radius}, values);
    const auto isSolid = [&](std::size_t i) {
        return static_cast<double>(values[i]) >= settings.isovalue;
    };
    for (std::size_t i = 0; i < kParts; ++i)
        if (isSolid(i) != isSolid(i + 1))
            return Interval{t[i], t[i + 1]};
    return std::nullopt;
}

glm::dvec3 gradientAt(const Field& field, const glm::dvec3& point, double radius)
{
    glm::dvec3 gradient{0.0};
    field.gradient(
        {{&point.x, 1}, {&point.y, 1}, {&point.z, 1}, {&radius, 1}},
        {{&gradient.x, 1}, {&gradient.y, 1}, {&gradient.z, 1}});
    return gradient;
}

} // namespace

std::optional<FieldRay> clipped(const FieldRay& ray, const core::Box& box)
{
    FieldRay inside = ray;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        const double origin = ray.origin[axis];
        const double direction = ray.direction[axis];
        if (direction == 0) {
            if (!(box.low[axis] <= origin && origin <= box.high[axis]))
                return std::nullopt;
            continue;
        }
        const auto [first, last] = std::minmax(
            {(box.low[axis] - origin) / direction, (box.high[axis] - origin) / direction});
        inside.from = std::max(inside.from, first);
        inside.to = std::min(inside.to, last);
    }
    if (!(inside.from <= inside.to))
        return std::nullopt;
    return inside;
}

core::Result<std::optional<FieldRayHit>>
castRay(const Field& field, const FieldRay& ray, const FieldRaySettings& settings)
{
    const double part = settings.step / glm::length(ray.direction);
    std::vector<Interval> open{{ray.from, ray.to}}; // the nearest last
    while (!open.empty()) {
        if (settings.stop.stop_requested())
            return core::failure(core::ErrorCode::interrupted, "the ray was given up");
        const Interval interval = open.back();
        open.pop_back();
        core::Box box;
        box.include(ray.at(interval.first));
        box.include(ray.at(interval.second));
        if (!field.bounds(box, {settings.radius, settings.radius}).contains(settings.isovalue))
            continue;
        const double middle = 0.5 * (interval.first + interval.second);
        const bool isDivisible = interval.first < middle && middle < interval.second;
        if (isDivisible && interval.second - interval.first > kParts * part) {
            open.emplace_back(middle, interval.second);
            open.emplace_back(interval.first, middle);
            continue;
        }
        auto change = firstChange(field, ray, settings, interval);
        if (!change)
            continue;
        // down to neighbouring doubles
        for (auto finer = firstChange(field, ray, settings, *change); finer != change;
             finer = firstChange(field, ray, settings, *change))
            change = finer;
        const double t = 0.5 * (change->first + change->second);
        return FieldRayHit{t, gradientAt(field, ray.at(t), settings.radius)};
    }
    return std::optional<FieldRayHit>();
}

} // namespace isofront::fields
