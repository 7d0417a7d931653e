#include "isofront/hierarchy/Criterion.h"

#include <isofront/core/Assert.h>

#include <cmath>
#include <numbers>

namespace isofront::hierarchy {

namespace {

/// 2^(-level / 3)
double shrunk(int level)
{
    return std::exp2(-level / 3.0);
}

} // namespace

DistanceCriterion::DistanceCriterion(double domainEdge, double strength)
    : _reach(domainEdge * strength)
{
    ISOFRONT_ASSERT(_reach > 0, "the domain's edge and the strength must be positive");
}

double DistanceCriterion::refineDistance(const Diamond& diamond) const
{
    return _reach * shrunk(diamond.level);
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

double ProjectedErrorCriterion::refineDistance(const Diamond& diamond) const
{
    const double error = _estimate(diamond);
    return error > 0 ? error * _unitsPerError : kNever;
}

double longestLatticeEdge(int level, int latticeSize)
{
    return std::numbers::sqrt3 * axisStep(level, latticeSize);
}

double axisStep(int level, int latticeSize)
{
    return shrunk(level) / (2.0 * latticeSize);
}

} // namespace isofront::hierarchy
