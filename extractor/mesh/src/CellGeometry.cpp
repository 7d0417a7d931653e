#include "CellGeometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>

namespace isofront::extractor {

namespace {

std::uint32_t maxNormDistance(const hierarchy::LatticePoint& a, const hierarchy::LatticePoint& b)
{
    std::uint32_t distance = 0;
    for (std::size_t axis = 0; axis < 3; ++axis)
        distance = std::max(distance, a[axis] < b[axis] ? b[axis] - a[axis] : a[axis] - b[axis]);
    return distance;
}

/// Exact but for the root: coordinates differ by small multiples of one power of two.
double distance(const hierarchy::LatticePoint& a, const hierarchy::LatticePoint& b)
{
    double squared = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double d = double(a[axis]) - double(b[axis]);
        squared += d * d;
    }
    return std::sqrt(squared);
}

/// The nearest whole number to one that is not negative, halves up: std::llround without the call.
std::int64_t rounded(double value)
{
    const auto whole = static_cast<std::int64_t>(value);
    return whole + (value - static_cast<double>(whole) >= 0.5 ? 1 : 0);
}

} // namespace

CellGeometry::CellGeometry(
    const hierarchy::Tetrahedron& cell, const hierarchy::Domain& domain, int latticeSize)
    : mirrored(cell.isMirrored()), low(cell.low()), high(cell.high())
{
    std::iota(sorted.begin(), sorted.end(), std::size_t{0});
    std::ranges::sort(sorted, {}, [&](std::size_t i) { return cell.corner[i]; });

    for (std::size_t i = 0, edge = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j, ++edge)
            edgeRadius[edge] = distance(cell.corner[sorted[i]], cell.corner[sorted[j]]) *
                               domain.latticeUnit() / latticeSize;

    // A feature's unit is 2^-14 of the max-norm of its shortest edge, a power of two.
    for (unsigned feature = 0; feature < 16; ++feature) {
        std::uint32_t shortest = 0;
        for (unsigned i = 0; i < 4; ++i)
            for (unsigned j = i + 1; j < 4; ++j) {
                if ((feature >> i & 1U) != 0 || (feature >> j & 1U) != 0)
                    continue;
                const std::uint32_t length = maxNormDistance(cell.corner[i], cell.corner[j]);
                if (shortest == 0 || length < shortest)
                    shortest = length;
            }
        if (shortest != 0)
            snapExponent[feature] =
                std::countr_zero(shortest) + hierarchy::kGridBitsPerLatticeUnit - 14;
    }
    cellExponent = snapExponent[0];
    // corners are lattice points, multiples of every unit
    for (const unsigned corner : {0b0111U, 0b1011U, 0b1101U, 0b1110U, 0b1111U})
        snapExponent[corner] = cellExponent;
    for (std::size_t feature = 0; feature < snapExponent.size(); ++feature)
        unitsPerLatticeUnit[feature] =
            std::ldexp(1.0, hierarchy::kGridBitsPerLatticeUnit - snapExponent[feature]);
}

hierarchy::GridPoint
CellGeometry::snapped(const glm::dvec3& p, FeatureMask feature, std::uint32_t denominator) const
{
    const int exponent = snapExponent[feature];
    const double toUnits = unitsPerLatticeUnit[feature] / denominator;
    return {
        rounded(p.x * toUnits) << exponent,
        rounded(p.y * toUnits) << exponent,
        rounded(p.z * toUnits) << exponent};
}

} // namespace isofront::extractor
