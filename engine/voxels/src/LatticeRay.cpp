#include "LatticeRay.h"

#include <isofront/core/Assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

// Based on:
// - J. Amanatides and A. Woo, "A fast voxel traversal algorithm for ray tracing" (1987), for the
//   walk; here with exact comparisons and cubes of any size;
// - H. Edelsbrunner and E. Mücke, "Simulation of simplicity" (1990), for the rule at ties.

namespace isofront::voxels {

namespace {

constexpr double kCube = std::int64_t{1} << LatticeRay::kBits;

struct Quotient {
    std::int64_t floor;
    bool exact;
};

/// Exact, for a quotient below 2^33 and a divisor from 1 to 2^30: the estimate in double is off by
/// less than one, and the remainder tells which way.
Quotient divided(std::int64_t dividend, std::int64_t divisor, double inverse)
{
    auto floor = static_cast<std::int64_t>(static_cast<double>(dividend) * inverse);
    std::int64_t rest = dividend - floor * divisor;
    while (rest < 0) {
        rest += divisor;
        --floor;
    }
    while (rest >= divisor) {
        rest -= divisor;
        ++floor;
    }
    return {floor, rest == 0};
}

/// How far along `direction` the box from -1/2 to 3/2 cubes begins, for starts outside that from -1
/// to 2; 0 within it. Nothing for a miss.
std::optional<double> approach(const glm::dvec3& start, const glm::dvec3& direction)
{
    if (glm::all(glm::greaterThanEqual(start, glm::dvec3(-kCube))) &&
        glm::all(glm::lessThanEqual(start, glm::dvec3(2 * kCube))))
        return 0;
    double near = 0;
    double far = std::numeric_limits<double>::infinity();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double low = -0.5 * kCube - start[axis];
        const double high = 1.5 * kCube - start[axis];
        if (direction[axis] == 0) {
            if (low > 0 || high < 0)
                return std::nullopt;
            continue;
        }
        const double a = low / direction[axis];
        const double b = high / direction[axis];
        near = std::max(near, std::min(a, b));
        far = std::min(far, std::max(a, b));
    }
    if (!(near <= far))
        return std::nullopt;
    return near;
}

} // namespace

std::optional<LatticeRay> LatticeRay::from(const VoxelLattice& lattice, const Ray& ray)
{
    const int cellBits = 7 + static_cast<int>(lattice.levels);
    const double steps = std::ldexp(1.0, kBits - cellBits) / lattice.edge; // a world unit
    const glm::dvec3 start = (ray.start - lattice.origin) * steps;
    const double longest =
        std::max({std::abs(ray.direction.x), std::abs(ray.direction.y), std::abs(ray.direction.z)});
    if (!std::isfinite(start.x + start.y + start.z) || !std::isfinite(longest) || !(longest > 0))
        return std::nullopt;
    const glm::dvec3 direction = glm::round(ray.direction / longest * kCube);
    const std::optional<double> skipped = approach(start, direction);
    if (!skipped)
        return std::nullopt;
    const glm::dvec3 place = start + *skipped * direction;
    if (!glm::all(
            glm::lessThanEqual(glm::abs(place - glm::dvec3(0.5 * kCube)), glm::dvec3(1.5 * kCube))))
        return std::nullopt; // so far away that rounding took it elsewhere
    std::array<std::int64_t, 3> from{};
    std::array<std::int64_t, 3> along{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        from[axis] = std::llround(place[axis]);
        along[axis] = std::llround(direction[axis]);
    }
    LatticeRay result(from, along, cellBits);
    result._scale = glm::length(direction) / steps;
    result._skipped = *skipped * result._scale;
    return result;
}

LatticeRay::LatticeRay(
    const std::array<std::int64_t, 3>& start,
    const std::array<std::int64_t, 3>& direction,
    int cellBits)
    : _cellBits(cellBits), _stepBits(kBits - cellBits)
{
    ISOFRONT_ASSERT(
        direction != (std::array<std::int64_t, 3>{}), "a ray without a direction goes nowhere");
    for (std::size_t i = 0; i < 3; ++i) {
        const std::int64_t size = std::abs(direction[i]);
        _axis[i] = {
            start[i],
            direction[i],
            size,
            size > 0 ? 1.0 / static_cast<double>(size) : 0.0,
            direction[i] >= 0 ? i : 5 - i};
    }
}

std::int64_t LatticeRay::cellAt(const Axis& axis, const Axis& crossed, std::int64_t rise) const
{
    const Quotient moved = divided(axis.direction * rise, crossed.size, crossed.inverse);
    const std::int64_t position = axis.start + moved.floor;
    const std::int64_t cell = position >> _stepBits;
    const bool onPlane = moved.exact && cell << _stepBits == position;
    if (!onPlane || axis.direction == 0)
        return cell;
    // both planes at once: which side it is on depends on which is crossed first
    const bool already = axis.rank < crossed.rank;
    return already == (axis.direction > 0) ? cell : cell - 1;
}

std::optional<LatticeRay::Place> LatticeRay::begin() const
{
    Place place;
    std::array<std::int64_t, 3> cell{};
    const std::int64_t cells = std::int64_t{1} << _cellBits;
    std::size_t last = kNoAxis;
    std::int64_t lastRise = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Axis& a = _axis[i];
        cell[i] = a.start >> _stepBits;
        if (cell[i] >= 0 && cell[i] < cells)
            continue;
        const bool up = cell[i] < 0;
        if (up ? a.direction <= 0 : a.direction >= 0)
            return std::nullopt;
        const std::int64_t rise = up ? -a.start : a.start - (std::int64_t{1} << kBits);
        if (last == kNoAxis || before(last, lastRise, i, rise)) {
            last = i;
            lastRise = rise;
        }
    }
    if (last != kNoAxis) {
        const Axis& crossed = _axis[last];
        for (std::size_t i = 0; i < 3; ++i) {
            cell[i] = i != last               ? cellAt(_axis[i], crossed, lastRise)
                      : crossed.direction > 0 ? 0
                                              : cells - 1;
            if (cell[i] < 0 || cell[i] >= cells)
                return std::nullopt;
        }
        place.axis = last;
        place.rise = lastRise;
    }
    for (std::size_t i = 0; i < 3; ++i)
        place.cell[i] = static_cast<std::int32_t>(cell[i]);
    return place;
}

void LatticeRay::leave(Place& place, int bits) const
{
    std::size_t first = kNoAxis;
    std::int64_t firstRise = 0;
    std::int64_t firstCell = 0;
    for (std::size_t i = 0; i < 3; ++i) {
        const Axis& a = _axis[i];
        if (a.direction == 0)
            continue;
        const std::int64_t low = std::int64_t{place.cell[i]} >> bits << bits;
        const std::int64_t plane = a.direction > 0 ? low + (std::int64_t{1} << bits) : low;
        const std::int64_t distance = (plane << _stepBits) - a.start;
        const std::int64_t rise = a.direction > 0 ? distance : -distance;
        if (first == kNoAxis || before(i, rise, first, firstRise)) {
            first = i;
            firstRise = rise;
            firstCell = a.direction > 0 ? plane : plane - 1;
        }
    }
    const Axis& crossed = _axis[first];
    for (std::size_t i = 0; i < 3; ++i) {
        place.cell[i] = static_cast<std::int32_t>(
            i == first ? firstCell : cellAt(_axis[i], crossed, firstRise));
    }
    place.axis = first;
    place.rise = firstRise;
}

double LatticeRay::distance(const Place& place) const
{
    if (place.axis == kNoAxis)
        return _skipped;
    const Axis& crossed = _axis[place.axis];
    // one rounding of the exact quotient, so that the order of places is kept
    const double parameter = static_cast<double>(place.rise) / static_cast<double>(crossed.size);
    return _skipped + parameter * _scale;
}

std::optional<Face> LatticeRay::face(const Place& place) const
{
    if (place.axis == kNoAxis)
        return std::nullopt;
    const bool up = _axis[place.axis].direction > 0;
    return static_cast<Face>(2 * place.axis + (up ? 0 : 1));
}

} // namespace isofront::voxels
