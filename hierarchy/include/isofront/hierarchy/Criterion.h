#pragma once

#include <isofront/core/Box.h>
#include <isofront/hierarchy/Diamond.h>
#include <isofront/hierarchy/Domain.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

namespace isofront::hierarchy {

/// How a diamond stands on a front when it is judged.
struct DiamondState {
    std::uint8_t cells = 0xff; ///< a bit for each tetrahedron that is a cell; all if it is split
    bool split = false;
};

/// Says how deep a place should be refined: a diamond is to be split while the viewer is nearer to
/// its bounding sphere than its refinement distance.
///
/// Every criterion we have takes this form, so that any number of them can be combined, and it
/// tells for free how far the viewer must travel before a decision can change.
///
/// Thread: calls come from the thread that updates the front.
class Criterion {
public:
    Criterion() = default;
    Criterion(const Criterion&) = delete;
    Criterion& operator=(const Criterion&) = delete;
    virtual ~Criterion() = default;

    /// [world]; infinite to split wherever the viewer is, negative never to split.
    [[nodiscard]] double refineDistance(const Diamond& diamond, DiamondState state = {}) const
    {
        return judge(diamond, state);
    }

private:
    [[nodiscard]] virtual double judge(const Diamond& diamond, DiamondState state) const = 0;
};

using CriterionPointer = std::shared_ptr<const Criterion>;

/// Estimated distance between the mesh in a diamond and the true surface [world]; 0 where there is
/// no surface, which is then never refined for its own sake.
using ErrorEstimate = std::function<double(const Diamond&, DiamondState)>;

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
    /// @param base        a, in (0, 1): the share of its distance to which a level's reach shrinks
    ///                    from that of the level above
    DistanceCriterion(double domainEdge, double strength, double base = kConstantSize);

    /// 2^(-1/3): cells of all levels look equally large where they appear.
    static constexpr double kConstantSize = 0.79370052598409979;

    /// The K at which the longest lattice edge of a cell covers at most so many pixels.
    /// @param latticeSize    n, lattice segments along the edge of a hexahedron
    /// @param pixelsPerUnit  of the view
    static double strengthFor(int latticeSize, double pixelsPerUnit, double pixels);

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    double _reach;
    double _base;
};

/// A place is refined until its estimated error, projected to the screen, is small enough.
class ProjectedErrorCriterion final : public Criterion {
public:
    /// @param pixelsPerUnit  of the view, see View::pixelsPerUnit
    /// @param pixels         the error that may be seen [px], > 0
    ProjectedErrorCriterion(ErrorEstimate estimate, double pixelsPerUnit, double pixels);

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    ErrorEstimate _estimate;
    double _unitsPerError;
};

/// A place to refine whoever looks from wherever: all points within `radius` of a box. A box of no
/// size is the centre of a sphere.
struct Focus {
    core::Box box;            ///< [world]; not empty
    double radius = 0;        ///< [world], >= 0
    double error = 0;         ///< estimated error to allow inside [world], > 0
    double falloff = 0;       ///< by which the error to allow grows per unit of distance, >= 0
    int maxLevel = kMaxLevel; ///< no finer than this for the focus' sake
};

/// An area of interest is refined until its estimated error is small enough.
class FocusCriterion final : public Criterion {
public:
    FocusCriterion(const Domain& domain, Focus focus, ErrorEstimate estimate);

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    Domain _domain;
    Focus _focus;
    ErrorEstimate _estimate;
    double _stretch;
};

/// What any of several criteria asks for.
class AnyCriterion final : public Criterion {
public:
    explicit AnyCriterion(std::vector<CriterionPointer> criteria) : _criteria(std::move(criteria))
    {
    }

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    std::vector<CriterionPointer> _criteria;
};

/// Another criterion with its distances scaled place by place: what is hidden, for example, matters
/// less. What is to be refined wherever the viewer is, stays so.
class BiasedCriterion final : public Criterion {
public:
    /// A share, >= 0, of a diamond's refinement distance. It must stay the same for a diamond.
    using Bias = std::function<double(const Diamond&)>;

    BiasedCriterion(CriterionPointer criterion, Bias bias)
        : _criterion(std::move(criterion)), _bias(std::move(bias))
    {
    }

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    CriterionPointer _criterion;
    Bias _bias;
};

/// Another criterion that refines nothing for a viewer who is further away than this, also not what
/// it would always refine.
class CappedCriterion final : public Criterion {
public:
    /// @param reach  [world], >= 0
    CappedCriterion(CriterionPointer criterion, double reach);

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState state) const override;

    CriterionPointer _criterion;
    double _reach;
};

/// The same level everywhere.
class UniformCriterion final : public Criterion {
public:
    explicit UniformCriterion(int level) : _level(level) {}

private:
    [[nodiscard]] double judge(const Diamond& diamond, DiamondState) const override
    {
        if (diamond.level < _level)
            return kAlways;
        return kNever;
    }

    int _level;
};

/// Length of the longest lattice edge of a cell of that level, for lattices of n segments [units of
/// the domain's edge].
double longestLatticeEdge(int level, int latticeSize);

/// Length of a lattice edge along an axis in a cell of level 3k, S / (2 n 2^k), and between those
/// levels the same law [units of the domain's edge].
double axisStep(int level, int latticeSize);

} // namespace isofront::hierarchy
