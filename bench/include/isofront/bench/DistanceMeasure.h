#pragma once

#include "isofront/bench/TriangleTree.h"
#include "isofront/bench/TrueSurface.h"

#include <isofront/core/Box.h>
#include <isofront/core/Jobs.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/TriangleMesh.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

namespace isofront::bench {

/// Points spread over a mesh evenly by area, always the same ones.
struct MeshSamples {
    std::vector<glm::dvec3> points;       ///< [world]
    std::vector<glm::dvec3> normals;      ///< unit, interpolated; zero if the mesh has none
    std::vector<std::uint32_t> triangles; ///< that each lies in
};

/// How densely a place should be sampled: at a triangle's middle, its normal of the length of its
/// area. Never negative.
using Density = std::function<double(const glm::dvec3& middle, const glm::dvec3& area)>;

/// The same number of points to each pixel of a picture, whatever hides what: pixels that a
/// triangle covers, 0 outside the picture.
Density pixelDensity(const hierarchy::View& view);

/// @param count    of points; a mesh without area gives none
/// @param density  spreads them otherwise than by area; empty for by area
MeshSamples
samplesOf(const surface::TriangleMesh& mesh, std::size_t count, const Density& density = {});

/// How large some errors are. All zero if nothing was measured.
struct ErrorSpread {
    double rms = 0;
    double p99 = 0; ///< that 99 % stay below, by nearest rank
    double max = 0;
    std::size_t samples = 0;
};

ErrorSpread spreadOf(std::vector<double> errors);

/// Dense points of a true surface, and the parts that it has.
struct Reference {
    std::vector<glm::dvec3> points;        ///< on the surface [world]
    std::vector<std::uint32_t> components; ///< that each belongs to
    std::size_t componentCount = 0;        ///< those with a point
};

/// Points of a surface, by a fine mesh of it that is projected. Each part of the mesh has some,
/// however small it is.
/// @param reach     how far the mesh may lie from the surface [world]
/// @param interior  points outside are left out [world]
Reference referenceOf(
    const TrueSurface& surface,
    const surface::TriangleMesh& fineMesh,
    double reach,
    const core::Box& interior,
    std::size_t count,
    core::Jobs& jobs,
    const Density& density = {});

/// Those points of a reference that a viewer sees.
/// @param fineMesh    of the same surface: what hides points from the viewer
/// @param stepPixels  that a lattice step of it covers [px]; what lies less than two of them behind
///                    it is not hidden
Reference seenOf(
    const Reference& reference,
    const surface::TriangleMesh& fineMesh,
    const hierarchy::View& view,
    double stepPixels,
    core::Jobs& jobs);

/// How far a mesh and a surface lie from each other.
struct SurfaceError {
    ErrorSpread toSurface; ///< from points of the mesh to the surface [world]
    ErrorSpread toMesh;    ///< from points of the surface to the mesh [world]
    ErrorSpread normal;    ///< between the normals of mesh and surface, at points of the mesh [deg]
    /// Share of the points of the mesh without a surface within reach. They count as `reach`.
    double lostShare = 0;
    std::size_t missedComponents =
        0; ///< of the surface: no point within a lattice step of the mesh
};

/// Measures meshes against one surface, all with the same points of it.
///
/// DESIGN contract of all error figures: distance to the unfiltered surface, both ways, root of the
/// mean square, 99th percentile and maximum, within an interior that keeps the border of the domain
/// out.
class DistanceMeasure {
public:
    /// @param samples  on each mesh
    DistanceMeasure(
        TrueSurface surface,
        Reference reference,
        core::Box interior,
        double reach,
        std::size_t samples,
        std::shared_ptr<core::Jobs> jobs);

    /// @param step  of the mesh's lattice [world]
    [[nodiscard]] SurfaceError of(const surface::TriangleMesh& mesh, double step) const;

    /// The same on the screen: distances across the line of sight and along it alike, divided by
    /// how far away they are [px], at points spread evenly over the picture. Those outside the
    /// picture or behind the mesh are left out; the reference must be what is seen (see `seenOf`).
    /// @param stepPixels  that a lattice step of the mesh covers [px]
    [[nodiscard]] SurfaceError
    of(const surface::TriangleMesh& mesh, const hierarchy::View& view, double stepPixels) const;

    [[nodiscard]] const Reference& reference() const { return _reference; }

private:
    /// What one unit of length is worth at a point; not above 0 if the point doesn't count.
    using Weight = std::function<double(const glm::dvec3&)>;
    /// The mesh's lattice step at a point [world].
    using Step = std::function<double(const glm::dvec3&)>;
    [[nodiscard]] SurfaceError weighted(
        const MeshSamples& samples,
        const TriangleTree& tree,
        const Step& step,
        const Weight& meshWeight,
        const Weight& surfaceWeight) const;

    TrueSurface _surface;
    Reference _reference;
    core::Box _interior;
    double _reach;
    std::size_t _samples;
    std::shared_ptr<core::Jobs> _jobs;
};

/// Between two meshes, points of the first to the second and back, together [world]: how much is
/// seen to pop where one takes the other's place.
ErrorSpread distanceBetween(
    const surface::TriangleMesh& first,
    const surface::TriangleMesh& second,
    const core::Box& interior,
    std::size_t samples,
    core::Jobs& jobs);

} // namespace isofront::bench
