#pragma once

#include <isofront/hierarchy/Criterion.h>

#include <optional>
#include <vector>

namespace isofront::surface {

/// Detail by distance alone: see hierarchy::DistanceCriterion.
struct DistanceLaw {
    double strength = 1;                                       ///< K, > 0
    double base = hierarchy::DistanceCriterion::kConstantSize; ///< a, in (0, 1)
};

/// What decides how fine the surface is, beside the error in pixels. Where several say something,
/// the finest counts.
struct DetailSettings {
    /// Estimated error to allow wherever the viewer is [world]; 0 for any.
    double worldError = 0;
    std::vector<hierarchy::Focus> focus; ///< places of interest
    /// By distance in place of the error in pixels.
    std::optional<DistanceLaw> distance;
    /// Share of their refinement distance for what is off the screen, (0, 1]; 0.5 lets it have
    /// twice the error.
    double offScreen = 1;
    /// Scales refinement distances place by place, for example of what is hidden. It must give the
    /// same for the same diamond until `Surface::setDetail` is called again. Empty for none.
    hierarchy::BiasedCriterion::Bias bias;
    /// How far from the viewer there is any detail for the viewer's sake [world], >= 0: what lies
    /// further away is refined no more than cracks and the other settings ask for. For those who
    /// show something else there, as surface voxels.
    double reach = hierarchy::kAlways;
    /// By how many levels a place may stay coarser than its level's expected error asks for, where
    /// its cells are measured to be good enough: 3 halve the lattice step. 0 does not measure,
    /// which costs about a tenth less a cell.
    int measuredLevels = 0;
};

} // namespace isofront::surface
