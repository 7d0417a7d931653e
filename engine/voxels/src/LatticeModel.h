#pragma once

#include "LatticeTriangle.h"
#include "MipMap.h"

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::voxels {

/// A model's corners on the lattice.
struct LatticeModel {
    const TriangleModel& model;
    VoxelLattice lattice;
    std::vector<std::array<std::int32_t, 3>> points; ///< of the model's positions [steps]
    std::vector<std::array<float, 4>> colours;       ///< linear, weighted by opacity; or none
    std::vector<MipMap> textures;

    [[nodiscard]] LatticeTriangle triangle(std::uint32_t index) const;
};

/// Why a model's colours and textures can't be what they should be, if so: badData.
std::optional<core::Error> checkColours(const TriangleModel& model);

/// The model must outlive what is made of it; its colours and textures are sound.
LatticeModel onLattice(const TriangleModel& model, const VoxelLattice& lattice);

} // namespace isofront::voxels
