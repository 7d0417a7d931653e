#include "isofront/surface/SurfaceCriterion.h"

#include <algorithm>

namespace isofront::surface {

namespace {

/// More diamonds than any front holds; beyond it the memory is given back and filled anew.
constexpr std::size_t kMostKnown = std::size_t{1} << 20U;

} // namespace

double expectedError(int level, int latticeSize, const hierarchy::Domain& domain)
{
    return kErrorPerStep * hierarchy::axisStep(level, latticeSize) * domain.edge *
           domain.worldFromField.stretch();
}

core::Box boxOf(const hierarchy::Diamond& diamond, const hierarchy::Domain& domain)
{
    // a diamond fills part of the cube of half edge h around its centre, cut by the domain
    const double unit = domain.latticeUnit();
    core::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double centre = diamond.centre[axis];
        const double low = std::max(centre - diamond.halfEdge, 0.0);
        const double high = std::min(centre + diamond.halfEdge, double(hierarchy::kLatticeEdge));
        box.low[axis] = domain.origin[axis] + unit * low;
        box.high[axis] = domain.origin[axis] + unit * high;
    }
    return box;
}

double WhereSurface::refineDistance(const hierarchy::Diamond& diamond) const
{
    const double distance = _criterion->refineDistance(diamond);
    return distance > 0 && provesEmpty(diamond) ? hierarchy::kNever : distance;
}

bool WhereSurface::provesEmpty(const hierarchy::Diamond& diamond) const
{
    if (const auto found = _known->find(diamond.centre); found != _known->end())
        return found->second;
    const bool empty = _extractor->provesEmpty(boxOf(diamond, _extractor->domain()));
    if (_known->size() >= kMostKnown)
        _known->clear();
    _known->emplace(diamond.centre, empty);
    return empty;
}

std::size_t WhereSurface::bytes() const
{
    return _known->size() * (sizeof(Known::value_type) + 3 * sizeof(void*));
}

std::shared_ptr<const WhereSurface> viewCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const WhereSurface* known)
{
    const auto estimate = [extractor](const hierarchy::Diamond& diamond) {
        return expectedError(diamond.level, extractor->settings().latticeSize, extractor->domain());
    };
    return std::make_shared<WhereSurface>(
        std::make_shared<hierarchy::ProjectedErrorCriterion>(estimate, pixelsPerUnit, pixels),
        extractor,
        known);
}

std::shared_ptr<const WhereSurface>
levelCriterion(const std::shared_ptr<const extractor::CellExtractor>& extractor, int level)
{
    return std::make_shared<WhereSurface>(
        std::make_shared<hierarchy::UniformCriterion>(level), extractor);
}

} // namespace isofront::surface
