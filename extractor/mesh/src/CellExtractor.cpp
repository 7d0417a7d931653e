#include "isofront/extractor/CellExtractor.h"

#include "CellGeometry.h"
#include "Decimation.h"
#include "EdgeAlignment.h"
#include "ErrorEstimate.h"
#include "Normals.h"
#include "RoughMesh.h"
#include "Samples.h"
#include "Smoothing.h"
#include "VertexBalance.h"
#include "isofront/extractor/MarchingCubesTable.h"

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
    RoughMesh mesh;
    std::vector<std::uint16_t> vertexOfEdge;
    std::vector<std::uint16_t> vertexOfPoint;
    PointColumns points;
    VertexMoves moves;
    SmoothingScratch smoothing;
    DecimationScratch decimation;
    AlignmentScratch alignment;
    BalanceScratch balance;
    std::vector<glm::dvec3> normals;
};

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Makes the triangles of one cell from its samples.
class Contour {
public:
    Contour(
        const CellGeometry& geometry,
        const VolumeMesh& mesh,
        const ExtractionSettings& settings,
        bool hasDataBox,
        CellScratch& scratch)
        : _geometry(geometry), _mesh(mesh), _settings(settings), _hasDataBox(hasDataBox),
          _scratch(scratch), _samples(scratch.samples)
    {
        _scratch.mesh.vertices.clear();
        _scratch.mesh.indices.clear();
        _scratch.vertexOfEdge.assign(mesh.edges.size(), kNoVertex);
    }

    void march()
    {
        const MarchingCubesTable& table = MarchingCubesTable::instance();
        const std::uint8_t* inside = _samples.inside.data();
        for (const Hexahedron& hexahedron : _mesh.hexahedra) {
            unsigned configuration = 0;
            for (unsigned m = 0; m < 8; ++m)
                configuration |= static_cast<unsigned>(inside[hexahedron.vertex[m]]) << m;
            const MarchingCubesTable::Case& entry = table[static_cast<std::uint8_t>(configuration)];
            for (std::size_t i = 0; i < entry.triangles; ++i) {
                const auto& [a, b, c] = entry.edge[i];
                emit(
                    crossingOf(hexahedron.edge[a]),
                    crossingOf(hexahedron.edge[b]),
                    crossingOf(hexahedron.edge[c]));
            }
        }
    }

    /// Closes the surface on those faces of the cell that lie on the domain's walls.
    void capWalls(const hierarchy::Tetrahedron& cell)
    {
        _scratch.vertexOfPoint.assign(_mesh.vertexCount(), kNoVertex);
        for (std::size_t apex = 0; apex < 4; ++apex)
            for (std::size_t axis = 0; axis < 3; ++axis)
                for (const std::uint32_t wall : {0U, hierarchy::kLatticeEdge}) {
                    bool onWall = true;
                    for (std::size_t k = 0; k < 4; ++k)
                        onWall = onWall && (k == apex || cell.corner[k][axis] == wall);
                    if (!onWall)
                        continue;
                    for (const BoundaryQuad& quad : _mesh.boundary[apex])
                        capQuad(quad);
                }
    }

private:
    /// The sample point in sample units.
    [[nodiscard]] glm::dvec3 samplePoint(std::uint16_t v) const
    {
        return {_samples.px[v], _samples.py[v], _samples.pz[v]};
    }

    /// The vertex where the surface cuts an edge of the lattice; the two ends are on different
    /// sides.
    std::uint16_t crossingOf(std::uint16_t edge)
    {
        if (_scratch.vertexOfEdge[edge] != kNoVertex)
            return _scratch.vertexOfEdge[edge];

        // from the inside end to the outside end: the same for every cell that has this edge
        auto [in, out] = _mesh.edges[edge];
        if (_samples.inside[in] == 0)
            std::swap(in, out);
        const double fieldIn = double(_samples.value[in]) - _settings.isovalue;
        const double fieldOut = double(_samples.value[out]) - _settings.isovalue;
        double t = fieldOut < 0 ? fieldIn / (fieldIn - fieldOut) : 2.0;
        bool cap = false;
        if (_hasDataBox && _samples.boxDistance[out] < 0) {
            // solid ends at the border of the data or at the surface, whichever comes first
            const double boxIn = _samples.boxDistance[in];
            const double boxT = boxIn / (boxIn - _samples.boxDistance[out]);
            cap = boxT < t;
            t = std::min(t, boxT);
        }
        t = clampedCrossing(t);

        const glm::dvec3 a = samplePoint(in);
        const glm::dvec3 b = samplePoint(out);
        const FeatureMask feature = _mesh.edgeFeature[edge];
        RoughVertex vertex;
        vertex.position = _geometry.snapped(a + t * (b - a), feature, _mesh.denominator());
        if (!_samples.radius.empty())
            vertex.radius = _samples.radiusAlong({in, out}, t);
        vertex.fallback = glm::normalize(b - a);
        vertex.ends = {in, out};
        vertex.t = t;
        for (std::size_t axis = 0; axis < 3; ++axis)
            vertex.key[axis] =
                static_cast<std::int64_t>(a[axis]) + static_cast<std::int64_t>(b[axis]);
        vertex.feature = feature;
        vertex.cap = cap;
        return _scratch.vertexOfEdge[edge] = push(vertex);
    }

    /// A lattice point as a vertex of a cap on a wall.
    std::uint16_t wallPoint(std::uint16_t point)
    {
        std::uint16_t& known = _scratch.vertexOfPoint[point];
        if (known != kNoVertex)
            return known;
        RoughVertex vertex;
        const glm::dvec3 p = samplePoint(point);
        vertex.position = _geometry.snapped(p, _mesh.vertexFeature[point], _mesh.denominator());
        // outward from all walls that meet here, whichever of them is being capped
        const double far = double(hierarchy::kLatticeEdge) * _mesh.denominator();
        glm::dvec3 outward(0.0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            outward[axis] = p[axis] == 0 ? -1.0 : p[axis] == far ? 1.0 : 0.0;
            vertex.key[axis] = 2 * static_cast<std::int64_t>(p[axis]);
        }
        vertex.fallback = glm::normalize(outward);
        vertex.feature = _mesh.vertexFeature[point];
        vertex.cap = true;
        vertex.wall = true;
        return known = push(vertex);
    }

    /// Marching squares on one side of a hexahedron, with the rule that the table has for sides: an
    /// ambiguous one separates its inside corners.
    void capQuad(const BoundaryQuad& quad)
    {
        std::array<bool, 4> in{};
        int count = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            in[i] = _samples.inside[quad.vertex[i]] != 0;
            count += in[i] ? 1 : 0;
        }
        if (count == 0)
            return;
        if (count == 2 && in[0] == in[2]) {
            for (std::size_t i = 0; i < 4; ++i)
                if (in[i])
                    emit(
                        crossingOf(quad.edge[(i + 3) % 4]),
                        wallPoint(quad.vertex[i]),
                        crossingOf(quad.edge[i]));
            return;
        }
        std::array<std::uint16_t, 6> polygon{};
        std::size_t sides = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            if (in[i])
                polygon[sides++] = wallPoint(quad.vertex[i]);
            if (in[i] != in[(i + 1) % 4])
                polygon[sides++] = crossingOf(quad.edge[i]);
        }
        for (std::size_t i = 2; i < sides; ++i)
            emit(polygon[0], polygon[i - 1], polygon[i]);
    }

    std::uint16_t push(const RoughVertex& vertex)
    {
        ISOFRONT_ASSERT(
            _scratch.mesh.vertices.size() < kNoVertex, "16-bit indices suffice up to n = 16");
        _scratch.mesh.vertices.push_back(vertex);
        return static_cast<std::uint16_t>(_scratch.mesh.vertices.size() - 1);
    }

    void emit(std::uint16_t a, std::uint16_t b, std::uint16_t c)
    {
        const auto& v = _scratch.mesh.vertices;
        if (!_settings.closed && v[a].cap && v[b].cap && v[c].cap)
            return;
        if (_geometry.mirrored)
            std::swap(b, c);
        _scratch.mesh.indices.insert(_scratch.mesh.indices.end(), {a, b, c});
    }

    const CellGeometry& _geometry;
    const VolumeMesh& _mesh;
    const ExtractionSettings& _settings;
    bool _hasDataBox;
    CellScratch& _scratch;
    const Samples& _samples;
};

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
        const Side side = sideOf(
            *_field,
            _dataBox,
            _settings.isovalue,
            sampleBox(geometry, _domain, mesh.denominator()),
            radius);
        if (side == Side::outside || (side == Side::inside && !mayCap)) {
            result.stats.provedEmpty = true;
            return true;
        }
    }

    Samples& samples = scratch.samples;
    samples.place(cell, geometry, _domain, mesh, _settings);
    if (isCancelled())
        return false;
    samples.take(*_field, _dataBox, _settings);
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

    Contour contour(geometry, mesh, _settings, _dataBox.has_value(), scratch);
    contour.march();
    if (mayCap)
        contour.capWalls(cell);
    scratch.mesh.compact();
    if (trace != nullptr)
        trace->contourSeconds += secondsSince(start);
    if (isCancelled())
        return false;

    const hierarchy::GridPoint corner = hierarchy::gridFromLattice(geometry.low);
    polish(cell, geometry, {corner, geometry.cellExponent}, scratch, trace);
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
            trace->borders.push_back({static_cast<std::uint16_t>(i), rough.feature, rough.key});
    }
    PointColumns& points = scratch.points;
    setNormals(
        *_field, _domain, _dataBox, _settings, scratch.mesh, points, scratch.normals, result);
    if (_settings.attributes && _field->hasAttributes())
        setAttributes(*_field, _domain, _settings, scratch.mesh, points, result);
    if (_settings.estimateError && !scratch.mesh.indices.empty())
        estimateError(*_field, _domain, _settings, scratch.mesh, points, result);
    if (trace != nullptr)
        trace->normalSeconds += secondsSince(start);
    return true;
}

void CellExtractor::polish(
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
        const auto takeNormals = [&] {
            vertexNormals(
                *_field,
                _domain,
                _dataBox,
                _settings,
                scratch.mesh,
                scratch.points,
                scratch.normals);
        };
        if (_settings.alignEdges) {
            takeNormals();
            alignEdges(scratch.mesh, frame, scratch.normals, localStep, scratch.alignment);
        }
        if (balanced) {
            takeNormals(); // aligning has put the vertices in another order
            scratch.moves.begin(scratch.mesh, frame);
            balanceInside(scratch.mesh, scratch.normals, localStep, scratch.moves, scratch.balance);
            scratch.moves.commit(scratch.mesh, frame);
        }
        if (trace != nullptr)
            trace->smoothSeconds += secondsSince(start);
    }
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
