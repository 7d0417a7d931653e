#pragma once

#include <isofront/hierarchy/Diamond.h>
#include <isofront/hierarchy/Domain.h>

#include <functional>
#include <limits>

namespace isofront::hierarchy {

/// Says how deep a place should be refined: a diamond is to be split while the viewer is nearer to
/// its bounding sphere than its refinement distance.
///
/// Every criterion we have takes this form, and it tells for free how far the viewer must travel
/// before a decision can change.
///
/// Thread: calls come from the thread that updates the front.
class Criterion {
public:
    Criterion() = default;
    Criterion(const Criterion&) = delete;
    Criterion& operator=(const Criterion&) = delete;
    virtual ~Criterion() = default;

    /// [world]; infinite to split wherever the viewer is, negative never to split.
    [[nodiscard]] virtual double refineDistance(const Diamond& diamond) const = 0;
};

inline constexpr double kAlways = std::numeric_limits<double>::infinity();
inline constexpr double kNever = -1.0;

/// Detail falls with distance alone: cells of level L appear within K S 2^(-L/3) of the viewer,
/// with S the domain's edge, so that their projected size is constant.
///
/// Source: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
/// of detail and applications", eq. 1. Differs: the base of their logarithm is 2^(-1/3), the one
/// for which the projected size is constant, and distance is measured in units of K S.
class DistanceCriterion final : public Criterion {
public:
    /// @param domainEdge  S [world]
    /// @param strength    K, > 0: see `strengthFor`
    DistanceCriterion(double domainEdge, double strength);

    [[nodiscard]] double refineDistance(const Diamond& diamond) const override;

    /// The K at which the longest lattice edge of a cell covers at most so many pixels.
    /// @param latticeSize    n, lattice segments along the edge of a hexahedron
    /// @param pixelsPerUnit  of the view
    static double strengthFor(int latticeSize, double pixelsPerUnit, double pixels);

private:
    double _reach;
};

/// A place is refined until its estimated error, projected to the screen, is small enough.
class ProjectedErrorCriterion final : public Criterion {
public:
    /// Estimated distance between the mesh in a diamond and the true surface [world]; 0 where there
    /// is no surface, which is then never refined for its own sake.
    using ErrorEstimate = std::function<double(const Diamond&)>;

    /// @param pixelsPerUnit  of the view, see View::pixelsPerUnit
    /// @param pixels         the error that may be seen [px], > 0
    ProjectedErrorCriterion(ErrorEstimate estimate, double pixelsPerUnit, double pixels);

    [[nodiscard]] double refineDistance(const Diamond& diamond) const override;

private:
    ErrorEstimate _estimate;
    double _unitsPerError;
};

/// The same level everywhere.
class UniformCriterion final : public Criterion {
public:
    explicit UniformCriterion(int level) : _level(level) {}
    [[nodiscard]] double refineDistance(const Diamond& diamond) const override
    {
        return diamond.level < _level ? kAlways : kNever;
    }

private:
    int _level;
};

/// Length of the longest lattice edge of a cell of that level, for lattices of n segments [units of
/// the domain's edge].
double longestLatticeEdge(int level, int latticeSize);

/// Length of a lattice edge along an axis in a cell of level 3k, S / (2 n 2^k), and between those
/// levels the same law [units of the domain's edge].
double axisStep(int level, int latticeSize);

} // namespace isofront::hierarchy
