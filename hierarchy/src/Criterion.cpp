#include "isofront/hierarchy/Criterion.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Powers.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace isofront::hierarchy {

namespace {

} // namespace

DistanceCriterion::DistanceCriterion(double domainEdge, double strength, double base)
    : _reach(domainEdge * strength), _base(base)
{
    ISOFRONT_ASSERT(_reach > 0, "the domain's edge and the strength must be positive");
    ISOFRONT_ASSERT(_base > 0 && _base < 1, "the base must lie between 0 and 1");
}

double DistanceCriterion::judge(const Diamond& diamond, DiamondState) const
{
    // the default base by the law that all lengths of a level follow, to the last bit
    return _reach * (_base == kConstantSize
                         ? core::twoToThirds(-diamond.level)
                         : core::wholePower(_base, static_cast<unsigned>(diamond.level)));
}

double DistanceCriterion::strengthFor(int latticeSize, double pixelsPerUnit, double pixels)
{
    return longestLatticeEdge(0, latticeSize) * pixelsPerUnit / pixels;
}

ProjectedErrorCriterion::ProjectedErrorCriterion(
    ErrorEstimate estimate, double pixelsPerUnit, double pixels)
    : _estimate(std::move(estimate)), _unitsPerError(pixelsPerUnit / pixels)
{
    ISOFRONT_ASSERT(_unitsPerError > 0, "pixels must be positive");
}

double ProjectedErrorCriterion::judge(const Diamond& diamond, DiamondState state) const
{
    const double error = _estimate(diamond, state);
    return error > 0 ? error * _unitsPerError : kNever;
}

FocusCriterion::FocusCriterion(const Domain& domain, Focus focus, ErrorEstimate estimate)
    : _domain(domain), _focus(focus), _estimate(std::move(estimate)),
      _stretch(domain.worldFromField.stretch())
{
    ISOFRONT_ASSERT(!focus.box.isEmpty() && focus.radius >= 0, "a focus is a place");
    ISOFRONT_ASSERT(focus.error > 0 && focus.falloff >= 0, "no error at all can't be reached");
}

double FocusCriterion::judge(const Diamond& diamond, DiamondState state) const
{
    if (diamond.level >= _focus.maxLevel)
        return kNever;
    const glm::dvec3 centre =
        _domain.worldFromField.point(_domain.fieldFromLattice(diamond.centre));
    const glm::dvec3 nearest = glm::clamp(centre, _focus.box.low, _focus.box.high);
    const double radius = diamond.radius() * _domain.latticeUnit() * _stretch;
    const double distance = std::max(0.0, glm::distance(centre, nearest) - radius - _focus.radius);
    if (distance > 0 && _focus.falloff == 0)
        return kNever;
    return _estimate(diamond, state) > _focus.error + _focus.falloff * distance ? kAlways : kNever;
}

double AnyCriterion::judge(const Diamond& diamond, DiamondState state) const
{
    double furthest = kNever;
    for (const CriterionPointer& criterion : _criteria)
        furthest = std::max(furthest, criterion->refineDistance(diamond, state));
    return furthest;
}

double BiasedCriterion::judge(const Diamond& diamond, DiamondState state) const
{
    const double distance = _criterion->refineDistance(diamond, state);
    return distance > 0 && distance < kAlways ? distance * _bias(diamond) : distance;
}

CappedCriterion::CappedCriterion(CriterionPointer criterion, double reach)
    : _criterion(std::move(criterion)), _reach(reach)
{
    ISOFRONT_ASSERT(_reach >= 0, "nothing can be nearer than the eye");
}

double CappedCriterion::judge(const Diamond& diamond, DiamondState state) const
{
    return std::min(_criterion->refineDistance(diamond, state), _reach);
}

double longestLatticeEdge(int level, int latticeSize)
{
    return std::numbers::sqrt3 * axisStep(level, latticeSize);
}

double axisStep(int level, int latticeSize)
{
    return core::twoToThirds(-level) / (2.0 * latticeSize);
}

} // namespace isofront::hierarchy
