#pragma once

#include <isofront/core/Affine.h>
#include <isofront/core/Box.h>
#include <isofront/hierarchy/LatticePoint.h>

#include <glm/ext/vector_int3_sized.hpp>
#include <glm/vec3.hpp>

#include <cmath>
#include <cstdint>

namespace isofront::hierarchy {

/// The world grid, on which mesh vertices lie, is 2^15 times finer than the lattice: the domain's
/// edge is 2^46 grid units long.
inline constexpr int kGridBits = 46;
inline constexpr int kGridBitsPerLatticeUnit = kGridBits - kLatticeBits;

/// A point of the world grid [grid units, from the domain's low corner].
using GridPoint = glm::i64vec3;

inline GridPoint gridFromLattice(const LatticePoint& p)
{
    return {
        std::int64_t{p.x} << kGridBitsPerLatticeUnit,
        std::int64_t{p.y} << kGridBitsPerLatticeUnit,
        std::int64_t{p.z} << kGridBitsPerLatticeUnit};
}

/// The cube in which a surface lives. It is axis-aligned in field space; an affine map takes it to
/// the world, so that volumes with any spacing and direction live on their own voxel indices.
struct Domain {
    glm::dvec3 origin{0.0}; ///< low corner [field]
    double edge = 1.0;      ///< [field], > 0 and finite
    core::Affine worldFromField{};

    /// Length of a lattice unit, of a grid unit [field].
    [[nodiscard]] double latticeUnit() const { return std::ldexp(edge, -kLatticeBits); }
    [[nodiscard]] double gridUnit() const { return std::ldexp(edge, -kGridBits); }

    [[nodiscard]] glm::dvec3 fieldFromLattice(const LatticePoint& p) const
    {
        return origin + latticeUnit() * glm::dvec3(p.x, p.y, p.z);
    }
    [[nodiscard]] glm::dvec3 fieldFromGrid(const GridPoint& p) const
    {
        return origin + gridUnit() * glm::dvec3(p);
    }
    [[nodiscard]] glm::dvec3 worldFromGrid(const GridPoint& p) const
    {
        return worldFromField.point(fieldFromGrid(p));
    }
    /// The nearest grid point to a world position, up to 2^16 domain edges away (clamped there).
    [[nodiscard]] GridPoint gridFromWorld(const glm::dvec3& world) const;
    [[nodiscard]] core::Box fieldBox() const { return {origin, origin + glm::dvec3(edge)}; }
};

} // namespace isofront::hierarchy
