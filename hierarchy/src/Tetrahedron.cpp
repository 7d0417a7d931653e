#include "isofront/hierarchy/Tetrahedron.h"

#include "isofront/hierarchy/Diamond.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <bit>
#include <cstdint>

namespace isofront::hierarchy {

LatticePoint Tetrahedron::spineCentre() const
{
    const LatticePoint& a = corner[0];
    const LatticePoint& b = corner[spineEnd()];
    LatticePoint centre;
    for (std::size_t axis = 0; axis < 3; ++axis) // in 64 bits: two coordinates can be 2^31
        centre[axis] =
            static_cast<std::uint32_t>((std::uint64_t{a[axis]} + std::uint64_t{b[axis]}) / 2);
    return centre;
}

std::array<Tetrahedron, 2> Tetrahedron::bisected() const
{
    ISOFRONT_ASSERT(level < kMaxLevel, "a tetrahedron of the deepest level can't be bisected");
    const std::size_t d = spineEnd();
    const LatticePoint centre = spineCentre();

    Tetrahedron first{corner, level + 1};
    first.corner[d] = centre;

    Tetrahedron second{corner, level + 1};
    for (std::size_t i = 0; i < d; ++i)
        second.corner[i] = corner[i + 1];
    second.corner[d] = centre;
    return {first, second};
}

bool Tetrahedron::isMirrored() const
{
    // Differences of corners are multiples of one power of two and at most twice it, so that the
    // determinant of what is left after shifting is a small number.
    std::array<std::array<std::int64_t, 3>, 3> d{};
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t axis = 0; axis < 3; ++axis) {
            d[i][axis] = std::int64_t{corner[i + 1][axis]} - std::int64_t{corner[0][axis]};
            bits |= static_cast<std::uint64_t>(d[i][axis]);
        }
    const std::int64_t unit = std::int64_t{1} << std::countr_zero(bits);
    for (auto& row : d)
        for (auto& value : row)
            value /= unit;
    const std::int64_t determinant = d[0][0] * (d[1][1] * d[2][2] - d[1][2] * d[2][1]) -
                                     d[0][1] * (d[1][0] * d[2][2] - d[1][2] * d[2][0]) +
                                     d[0][2] * (d[1][0] * d[2][1] - d[1][1] * d[2][0]);
    ISOFRONT_ASSERT(determinant != 0, "the tetrahedron is flat");
    return determinant < 0;
}

LatticePoint Tetrahedron::low() const
{
    LatticePoint result = corner[0];
    for (const LatticePoint& c : corner)
        result = {std::min(result.x, c.x), std::min(result.y, c.y), std::min(result.z, c.z)};
    return result;
}

LatticePoint Tetrahedron::high() const
{
    LatticePoint result = corner[0];
    for (const LatticePoint& c : corner)
        result = {std::max(result.x, c.x), std::max(result.y, c.y), std::max(result.z, c.z)};
    return result;
}

std::array<Tetrahedron, 6> rootTetrahedra()
{
    std::array<Tetrahedron, 6> roots;
    const DiamondTetrahedra all = tetrahedraOf(Diamond(kRootDiamond));
    for (std::size_t i = 0; i < roots.size(); ++i)
        roots[i] = all.tetrahedron(i);
    return roots;
}

} // namespace isofront::hierarchy
