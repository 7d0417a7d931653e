#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/Powers.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

namespace isofront::surface {

namespace {

/// More diamonds than any front holds; beyond it the memory is given back and filled anew.
constexpr std::size_t kMostKnown = std::size_t{1} << 20U;

/// What a node of a map takes beside its entry [bytes].
constexpr std::size_t kMapNode = 3 * sizeof(void*);

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

const extractor::BoxBounds&
DiamondBounds::of(const hierarchy::Diamond& diamond, const extractor::CellExtractor& extractor)
{
    if (const auto found = _known.find(diamond.centre); found != _known.end())
        return found->second;
    if (_known.size() >= kMostKnown)
        _known.clear();
    const core::Box box = boxOf(diamond, extractor.domain());
    return _known.emplace(diamond.centre, extractor.boundsOf(box)).first->second;
}

const extractor::BoxBounds* DiamondBounds::find(const hierarchy::LatticePoint& centre) const
{
    const auto found = _known.find(centre);
    return found == _known.end() ? nullptr : &found->second;
}

std::size_t DiamondBounds::bytes() const
{
    return _known.size() * (sizeof(decltype(_known)::value_type) + kMapNode);
}

void MeasuredErrors::record(
    const hierarchy::CellId& id, const extractor::CellMesh& mesh, double stretch)
{
    double error = double(mesh.stats.errorRms) * stretch;
    if (mesh.indices.empty())
        error = mesh.stats.provedEmpty ? 0.0 : std::numeric_limits<double>::infinity();
    if (_known.size() >= kMostKnown)
        _known.clear();
    const auto [entry, isNew] = _known.try_emplace(id.spine);
    if (isNew)
        entry->second.fill(std::numeric_limits<float>::quiet_NaN());
    entry->second[id.index] = static_cast<float>(error);
}

bool MeasuredErrors::isKnown(const hierarchy::CellId& id) const
{
    const auto found = _known.find(id.spine);
    return found != _known.end() && !std::isnan(found->second[id.index]);
}

bool MeasuredErrors::isProvedEmpty(const hierarchy::CellId& id) const
{
    const auto found = _known.find(id.spine);
    return found != _known.end() && found->second[id.index] == 0.0F;
}

MeasuredErrors::Error
MeasuredErrors::of(const hierarchy::LatticePoint& centre, std::uint8_t cells) const
{
    const auto found = _known.find(centre);
    if (found == _known.end())
        return {0, cells == 0};
    Error error{0, true};
    for (unsigned left = cells; left != 0; left &= left - 1) {
        const double one = double(found->second[static_cast<std::size_t>(std::countr_zero(left))]);
        if (std::isnan(one))
            error.complete = false;
        else
            error.largest = std::max(error.largest, one);
    }
    return error;
}

std::size_t MeasuredErrors::bytes() const
{
    return _known.size() * (sizeof(decltype(_known)::value_type) + kMapNode);
}

bool WhereSurface::provesEmpty(const hierarchy::Diamond& diamond) const
{
    return _extractor->provesEmpty(_known->of(diamond, *_extractor));
}

double WhereSurface::judge(const hierarchy::Diamond& diamond, hierarchy::DiamondState state) const
{
    const double distance = _criterion->refineDistance(diamond, state);
    // the finest, too, are asked for their bounds, which another isovalue is tested against
    if (distance > 0 && (provesEmpty(diamond) || diamond.level >= _maxLevel))
        return hierarchy::kNever;
    return distance;
}

hierarchy::ErrorEstimate errorEstimate(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    std::shared_ptr<const MeasuredErrors> measured,
    int measuredLevels)
{
    const int latticeSize = extractor->settings().latticeSize;
    const hierarchy::Domain domain = extractor->domain();
    if (!measured || measuredLevels <= 0)
        return [=](const hierarchy::Diamond& diamond, hierarchy::DiamondState) {
            return expectedError(diamond.level, latticeSize, domain);
        };
    const double least = hierarchy::axisStep(measuredLevels, 1) / hierarchy::axisStep(0, 1);
    return [=, errors = std::move(measured)](
               const hierarchy::Diamond& diamond, hierarchy::DiamondState state) {
        const double expected = expectedError(diamond.level, latticeSize, domain);
        const MeasuredErrors::Error known = errors->of(diamond.centre, state.cells);
        if (!known.complete && state.split)
            return expected;
        return std::clamp(known.largest, expected * least, expected);
    };
}

hierarchy::CriterionPointer detailCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const DetailSettings& settings,
    std::shared_ptr<const MeasuredErrors> measured,
    double coarser)
{
    const hierarchy::Domain& domain = extractor->domain();
    const auto estimate = errorEstimate(extractor, std::move(measured), settings.measuredLevels);
    std::vector<hierarchy::CriterionPointer> criteria;
    if (settings.distance)
        criteria.push_back(std::make_shared<hierarchy::DistanceCriterion>(
            domain.edge * domain.worldFromField.stretch(),
            settings.distance->strength / coarser,
            settings.distance->base));
    else
        criteria.push_back(std::make_shared<hierarchy::ProjectedErrorCriterion>(
            estimate, pixelsPerUnit, pixels * coarser));
    if (settings.bias)
        criteria.back() =
            std::make_shared<hierarchy::BiasedCriterion>(criteria.back(), settings.bias);
    if (settings.reach < hierarchy::kAlways)
        criteria.back() =
            std::make_shared<hierarchy::CappedCriterion>(criteria.back(), settings.reach);
    std::vector<hierarchy::Focus> places = settings.focus;
    if (settings.worldError > 0) {
        hierarchy::Focus everywhere;
        everywhere.box = {glm::dvec3(0.0), glm::dvec3(0.0)};
        everywhere.radius = std::numeric_limits<double>::infinity();
        everywhere.error = settings.worldError;
        places.push_back(everywhere);
    }
    for (hierarchy::Focus& focus : places) {
        focus.error *= coarser;
        focus.falloff *= coarser;
        criteria.push_back(std::make_shared<hierarchy::FocusCriterion>(domain, focus, estimate));
    }
    return std::make_shared<hierarchy::AnyCriterion>(std::move(criteria));
}

int coarserLevel(int maxLevel, double coarser)
{
    // three levels halve the lattice step
    int finest = maxLevel;
    while (finest > 0 && core::twoToThirds(maxLevel - finest + 1) <= coarser)
        --finest;
    return finest;
}

std::shared_ptr<const WhereSurface> viewCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const DetailSettings& settings,
    std::shared_ptr<DiamondBounds> known,
    std::shared_ptr<const MeasuredErrors> measured,
    double coarser,
    int maxLevel)
{
    return std::make_shared<WhereSurface>(
        detailCriterion(extractor, pixelsPerUnit, pixels, settings, std::move(measured), coarser),
        extractor,
        std::move(known),
        coarserLevel(maxLevel, coarser));
}

std::shared_ptr<const WhereSurface>
levelCriterion(const std::shared_ptr<const extractor::CellExtractor>& extractor, int level)
{
    return std::make_shared<WhereSurface>(
        std::make_shared<hierarchy::UniformCriterion>(level), extractor);
}

} // namespace isofront::surface
