#pragma once

#include <isofront/core/Hash.h>

#include <compare>
#include <cstddef>
#include <cstdint>

namespace isofront::hierarchy {

/// The domain's edge is 2^31 lattice units long, so levels reach from 0 to 92.
inline constexpr int kLatticeBits = 31;
inline constexpr std::uint32_t kLatticeEdge = 1U << kLatticeBits;
/// The deepest level a tetrahedron can have: its own bisection would need half units.
inline constexpr int kMaxLevel = 3 * kLatticeBits - 1;

/// A point with integer coordinates, each in [0, 2^31] [lattice units]: the corner of a
/// tetrahedron or the centre of a diamond. All topology is exact arithmetic on these.
struct LatticePoint {
    std::uint32_t x = 0, y = 0, z = 0;

    auto operator<=>(const LatticePoint&) const = default;

    [[nodiscard]] std::uint32_t operator[](std::size_t axis) const
    {
        return axis == 0 ? x : axis == 1 ? y : z;
    }
    std::uint32_t& operator[](std::size_t axis) { return axis == 0 ? x : axis == 1 ? y : z; }
};

/// Outside of every domain: stands for no point at all.
inline constexpr LatticePoint kNoLatticePoint{0xFFFFFFFFU, 0xFFFFFFFFU, 0xFFFFFFFFU};

struct LatticePointHash {
    std::size_t operator()(const LatticePoint& p) const
    {
        return core::hashCombined((std::uint64_t{p.x} << 32U) | p.y, p.z);
    }
};

} // namespace isofront::hierarchy
