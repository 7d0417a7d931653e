#include "isofront/extractor/CellExtractor.h"

#include "CellGeometry.h"
#include "Contour.h"
#include "Decimation.h"
#include "EdgeAlignment.h"
#include "ErrorEstimate.h"
#include "Normals.h"
#include "RoughMesh.h"
#include "Samples.h"
#include "Smoothing.h"
#include "VertexBalance.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Hash.h>
#include <isofront/hierarchy/Criterion.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

namespace isofront::extractor {

/// What a worker reuses from cell to cell.
struct CellScratch {
    Samples samples;
    ContourScratch contour;
    RoughMesh mesh;
    PointColumns points;
    VertexMoves moves;
    SmoothingScratch smoothing;
    DecimationScratch decimation;
    AlignmentScratch alignment;
    BalanceScratch balance;
    std::vector<glm::dvec3> normals;
    std::vector<std::uint32_t> normalCodes;
};

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The box of a cell's sample points, by the very expression that places them, so that it holds
/// them whatever the rounding.
core::Box
sampleBox(const CellGeometry& geometry, const hierarchy::Domain& domain, double denominator)
{
    const double unit = domain.latticeUnit() / denominator;
    core::Box box;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        box.low[axis] = domain.origin[axis] + unit * (denominator * geometry.low[axis]);
        box.high[axis] = domain.origin[axis] + unit * (denominator * geometry.high[axis]);
    }
    return box;
}

bool holds(const core::Box& outer, const core::Box& inner)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (!(inner.low[axis] >= outer.low[axis] && inner.high[axis] <= outer.high[axis]))
            return false;
    return true;
}

bool touchesWall(const hierarchy::LatticePoint& low, const hierarchy::LatticePoint& high)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (low[axis] == 0 || high[axis] == hierarchy::kLatticeEdge)
            return true;
    return false;
}

/// What bounds say about a region: no triangle can arise there if all of it is on one side.
enum class Side { inside, outside, unknown };

Side sideOf(
    const fields::Field& field,
    const std::optional<core::Box>& dataBox,
    double isovalue,
    const core::Box& box,
    core::Interval radius)
{
    bool holdsBorder = false;
    if (dataBox) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            if (box.high[axis] < dataBox->low[axis] || box.low[axis] > dataBox->high[axis])
                return Side::outside;
            holdsBorder = holdsBorder || box.low[axis] < dataBox->low[axis] ||
                          box.high[axis] > dataBox->high[axis];
        }
    }
    const core::Interval values = field.bounds(box, radius);
    if (values.high < isovalue)
        return Side::outside;
    if (values.low >= isovalue && !holdsBorder)
        return Side::inside;
    return Side::unknown;
}

} // namespace

CellExtractor::CellExtractor(
    std::shared_ptr<const fields::Field> field,
    hierarchy::Domain domain,
    ExtractionSettings settings)
    : _field(std::move(field)), _dataBox(_field->dataBox()), _domain(domain), _settings(settings),
      _volumeMesh(&VolumeMesh::ofSize(settings.latticeSize))
{
    ISOFRONT_ASSERT(
        domain.edge > 0 && std::isfinite(domain.edge), "the domain's edge must be positive");
}

std::optional<CellMesh> CellExtractor::extract(
    const hierarchy::Tetrahedron& cell, CellTrace* trace, const std::atomic<bool>* cancelled) const
{
    CellMesh mesh;
    if (!extractInto(cell, mesh, trace, cancelled))
        return std::nullopt;
    return mesh;
}

bool CellExtractor::extractInto(
    const hierarchy::Tetrahedron& cell,
    CellMesh& result,
    CellTrace* trace,
    const std::atomic<bool>* cancelled) const
{
    thread_local CellScratch scratch;
    const auto isCancelled = [&] {
        return cancelled != nullptr && cancelled->load(std::memory_order_relaxed);
    };

    const VolumeMesh& mesh = *_volumeMesh;
    const CellGeometry geometry(cell, _domain, _settings.latticeSize);
    result.low = geometry.low;
    result.stats = {};
    result.vertices.clear();
    result.indices.clear();
    result.attributes.clear();
    result.exponent = static_cast<std::uint8_t>(geometry.cellExponent);

    auto start = Clock::now();
    const core::Box box = sampleBox(geometry, _domain, mesh.denominator());
    const bool mayCap = _settings.closed && touchesWall(geometry.low, geometry.high);
    if (_settings.skipEmptyCells) {
        core::Interval radius{0, 0};
        if (_settings.filterStrength > 0) {
            const auto [least, most] = std::ranges::minmax(geometry.edgeRadius);
            // rounding in the interpolation of radii is a few units in the last place
            radius.low =
                _settings.filterStrength * std::min(least, _settings.cornerRadius) * (1 - 1e-12);
            radius.high =
                _settings.filterStrength * std::max(most, _settings.cornerRadius) * (1 + 1e-12);
        }
        const Side side = sideOf(*_field, _dataBox, _settings.isovalue, box, radius);
        if (side == Side::outside || (side == Side::inside && !mayCap)) {
            result.stats.provedEmpty = true;
            return true;
        }
    }

    Samples& samples = scratch.samples;
    const bool leavesData = _dataBox && !holds(*_dataBox, box);
    samples.take(*_field, cell, geometry, _domain, leavesData ? _dataBox : std::nullopt, _settings);
    result.stats.samples = static_cast<std::uint32_t>(mesh.vertexCount());
    result.stats.sanitisedSamples = samples.sanitised;
    if (trace != nullptr)
        trace->sampleSeconds += secondsSince(start);
    if (isCancelled())
        return false;

    start = Clock::now();
    const std::size_t insideCount =
        static_cast<std::size_t>(std::ranges::count(samples.inside, std::uint8_t{1}));
    if (insideCount == 0 || (insideCount == samples.inside.size() && !mayCap))
        return true;

    Contour(geometry, mesh, _settings, samples, scratch.contour, scratch.mesh).run(cell, mayCap);
    if (trace != nullptr)
        trace->contourSeconds += secondsSince(start);
    if (isCancelled())
        return false;

    const hierarchy::GridPoint corner = hierarchy::gridFromLattice(geometry.low);
    const bool hasNormals = polish(cell, geometry, {corner, geometry.cellExponent}, scratch, trace);
    if (isCancelled())
        return false;

    start = Clock::now();
    result.vertices.resize(scratch.mesh.vertices.size());
    result.indices.assign(scratch.mesh.indices.begin(), scratch.mesh.indices.end());
    for (std::size_t i = 0; i < scratch.mesh.vertices.size(); ++i) {
        const RoughVertex& rough = scratch.mesh.vertices[i];
        CellVertex& vertex = result.vertices[i];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::int64_t local = (rough.position[axis] - corner[axis]) >> result.exponent;
            ISOFRONT_ASSERT(local >= 0 && local <= 32768, "a vertex left its cell");
            vertex.position[axis] = static_cast<std::uint16_t>(local);
        }
        vertex.flags = static_cast<std::uint16_t>(
            (rough.isBorder() ? CellVertex::border : 0) | (rough.cap ? CellVertex::cap : 0));
        if (trace != nullptr && rough.isBorder())
            trace->borders.push_back(
                {static_cast<std::uint16_t>(i), rough.feature, samples.key(rough.ends)});
    }
    PointColumns& points = scratch.points;
    if (hasNormals) {
        for (std::size_t i = 0; i < result.vertices.size(); ++i)
            result.vertices[i].normal = octahedral(scratch.normals[i]);
    } else {
        setNormals(
            *_field,
            _domain,
            _dataBox,
            _settings,
            samples,
            scratch.mesh,
            points,
            scratch.normalCodes,
            result);
    }
    if (_settings.attributes && _field->hasAttributes())
        setAttributes(*_field, _domain, _settings, scratch.mesh, points, result);
    if (_settings.estimateError && !scratch.mesh.indices.empty())
        estimateError(*_field, _domain, _settings, scratch.mesh, points, result);
    if (trace != nullptr)
        trace->normalSeconds += secondsSince(start);
    return true;
}

bool CellExtractor::polish(
    const hierarchy::Tetrahedron& cell,
    const CellGeometry& geometry,
    const CellFrame& frame,
    CellScratch& scratch,
    CellTrace* trace) const
{
    const double step = hierarchy::axisStep(cell.level, _settings.latticeSize);
    const double localStep = std::ldexp(step, hierarchy::kGridBits - frame.exponent);
    const bool balanced = _settings.vertices == VertexPlacement::balanced;
    if (balanced) {
        const auto start = Clock::now();
        balanceBorders(
            *_field,
            _domain,
            _settings,
            cell,
            geometry,
            *_volumeMesh,
            scratch.samples,
            scratch.mesh,
            scratch.points,
            scratch.balance);
        if (trace != nullptr)
            trace->smoothSeconds += secondsSince(start);
    }
    if (_settings.smoothIterations > 0 || _settings.reproject) {
        const auto start = Clock::now();
        scratch.moves.begin(scratch.mesh, frame);
        smooth(scratch.mesh, _settings.smoothIterations, scratch.moves, scratch.smoothing);
        if (_settings.reproject)
            reproject(
                *_field,
                _domain,
                _settings,
                scratch.mesh,
                frame,
                step * _domain.edge,
                scratch.moves,
                scratch.points);
        scratch.moves.commit(scratch.mesh, frame);
        if (trace != nullptr)
            trace->smoothSeconds += secondsSince(start);
    }
    if (_settings.simplifyError > 0) {
        const auto start = Clock::now();
        DecimationSettings decimation;
        decimation.tolerance = _settings.simplifyError * localStep;
        decimation.choices = _settings.simplifyChoices;
        for (const hierarchy::LatticePoint& p : cell.corner)
            decimation.seed = core::hashCombined(
                core::hashCombined(decimation.seed, (std::uint64_t{p.x} << 32U) | p.y), p.z);
        decimate(scratch.mesh, frame, decimation, scratch.decimation);
        if (trace != nullptr)
            trace->simplifySeconds += secondsSince(start);
    }
    if (_settings.alignEdges || balanced) {
        const auto start = Clock::now();
        vertexNormals(
            *_field,
            _domain,
            _dataBox,
            _settings,
            scratch.samples,
            scratch.mesh,
            scratch.points,
            scratch.normals);
        if (_settings.alignEdges)
            alignEdges(scratch.mesh, frame, scratch.normals, localStep, scratch.alignment);
        if (balanced) {
            scratch.moves.begin(scratch.mesh, frame);
            balanceInside(scratch.mesh, scratch.normals, localStep, scratch.moves, scratch.balance);
            scratch.moves.commit(scratch.mesh, frame);
        }
        if (trace != nullptr)
            trace->smoothSeconds += secondsSince(start);
    }
    return _settings.alignEdges && !balanced; // they are those of the vertices as they are now
}

BoxBounds CellExtractor::boundsOf(const core::Box& box) const
{
    const glm::dvec3 size = box.size();
    const double largest = std::max({size.x, size.y, size.z});
    core::Interval radius{0, 0};
    if (_settings.filterStrength > 0)
        radius.high = _settings.filterStrength *
                      std::max(2 * largest / _settings.latticeSize, _settings.cornerRadius);
    BoxBounds bounds;
    const core::Box whole = _domain.fieldBox();
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (_dataBox) {
            bounds.isOutside = bounds.isOutside || box.high[axis] < _dataBox->low[axis] ||
                               box.low[axis] > _dataBox->high[axis];
            bounds.holdsCaps = bounds.holdsCaps || box.low[axis] < _dataBox->low[axis] ||
                               box.high[axis] > _dataBox->high[axis];
        }
        if (_settings.closed)
            bounds.holdsCaps = bounds.holdsCaps || box.low[axis] <= whole.low[axis] ||
                               box.high[axis] >= whole.high[axis];
    }
    if (!bounds.isOutside)
        bounds.values = _field->bounds(box, radius);
    return bounds;
}

bool CellExtractor::provesEmpty(const BoxBounds& bounds) const
{
    const double isovalue = _settings.isovalue;
    return bounds.isOutside || bounds.values.high < isovalue ||
           (bounds.values.low >= isovalue && !bounds.holdsCaps);
}

} // namespace isofront::extractor
