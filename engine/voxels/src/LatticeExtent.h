#pragma once

#include "LatticeTriangle.h"

#include <isofront/core/Box.h>
#include <isofront/voxels/Voxelization.h>

#include <glm/vec3.hpp>

#include <cmath>

namespace isofront::voxels {

/// Looks at each component: the sum of finite ones may not be finite.
inline bool isFinite(const glm::dvec3& p)
{
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Whether all places in a box can be given in steps of a lattice that begins at its low end: their
/// coordinates may be too large, too small, or too close together for that.
inline bool canDivide(const VoxelLattice& lattice, const core::Box& box)
{
    const glm::dvec3 next = lattice.origin + lattice.edge;
    return std::isnormal(lattice.edge) &&
           std::isfinite(static_cast<double>(kSteps) / lattice.edge) && isFinite(lattice.origin) &&
           isFinite(box.high - lattice.origin) && next.x != lattice.origin.x &&
           next.y != lattice.origin.y && next.z != lattice.origin.z;
}

} // namespace isofront::voxels
