#pragma once

#include <isofront/core/Affine.h>
#include <isofront/core/Jobs.h>
#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <memory>
#include <span>
#include <vector>

namespace isofront::bench {

/// Where a field passes its isovalue: what meshes are held against. Finds the nearest point of it
/// in double, from the field's own values and gradients.
///
/// Thread: any.
class TrueSurface {
public:
    /// @param filterRadius  of all samples [field]; 0 is the unfiltered field
    TrueSurface(
        std::shared_ptr<const fields::Field> field,
        double isovalue,
        core::Affine worldFromField = {},
        double filterRadius = 0);

    struct Landing {
        glm::dvec3 point{0.0};  ///< on the surface [world]
        glm::dvec3 normal{0.0}; ///< unit, down the field
        bool found = false;     ///< otherwise there is no surface within reach that we can find
    };

    /// The nearest point of the surface to each of these, within `reach` [world].
    ///
    /// Newton steps along the gradient, then steps within the tangent plane towards the point
    /// itself, because where a gradient leads is not the nearest place on a curved surface. Where
    /// that fails, the first sign change along the gradient is halved until it is met. A thin part
    /// of a surface that turns its back may be missed for a farther one: distances are never too
    /// small.
    [[nodiscard]] std::vector<Landing>
    project(std::span<const glm::dvec3> points, double reach, core::Jobs& jobs) const;

private:
    class Batch;

    std::shared_ptr<const fields::Field> _field;
    double _isovalue;
    core::Affine _worldFromField;
    core::Affine _fieldFromWorld;
    double _filterRadius;
};

} // namespace isofront::bench
