#include "FieldGrid.h"

#include <isofront/core/Powers.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::voxels {

namespace {

/// Values beyond are taken for it.
constexpr double kHuge = std::numeric_limits<float>::max() / 4;

glm::dvec3 vectorOf(const HalfPlace& place)
{
    return {
        static_cast<double>(place[0]),
        static_cast<double>(place[1]),
        static_cast<double>(place[2])};
}

/// The factor of a map that does nothing but scale and move.
std::optional<double> scaleOf(const glm::dmat3& linear)
{
    const double scale = linear[0][0];
    if (scale > 0 && linear == glm::dmat3(scale))
        return scale;
    return std::nullopt;
}

} // namespace

std::array<std::uint32_t, 3> voxelCounts(const FieldVoxelizationSettings& settings)
{
    const glm::dvec3 size = settings.box.size() / settings.edge;
    std::array<std::uint32_t, 3> counts{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        counts[axis] = static_cast<std::uint32_t>(std::clamp(
            std::ceil(size[static_cast<glm::length_t>(axis)] - 1e-6), 1.0, kMaxResolution + 1.0));
    return counts;
}

void FieldPoints::clear()
{
    x.clear();
    y.clear();
    z.clear();
}

void FieldPoints::add(const glm::dvec3& point)
{
    x.push_back(point.x);
    y.push_back(point.y);
    z.push_back(point.z);
}

FieldGrid::FieldGrid(
    const fields::Field& field,
    const FieldVoxelizationSettings& settings,
    const VoxelLattice& lattice)
    : _field(field), _isovalue(settings.isovalue), _origin(lattice.origin),
      _half(0.5 * lattice.edge), _fieldFromWorld(settings.worldFromField.inverse()),
      _worldFromGradient(glm::transpose(_fieldFromWorld.linear)),
      _scale(scaleOf(_fieldFromWorld.linear)), _data(field.dataBox())
{
    const double shrink = core::cubeRoot(std::abs(glm::determinant(_fieldFromWorld.linear)));
    _radius = settings.filterStrength * 2 * lattice.edge * shrink;
    _slack = 1e-6 * lattice.edge * shrink;
    const std::array<std::uint32_t, 3> counts = voxelCounts(settings);
    std::ranges::copy(counts, _counts.begin());
}

glm::dvec3 FieldGrid::fieldPoint(const glm::dvec3& place) const
{
    return _fieldFromWorld.point(_origin + _half * place);
}

glm::dvec3 FieldGrid::fieldPoint(const HalfPlace& place) const
{
    return fieldPoint(vectorOf(place));
}

bool FieldGrid::hasData(const HalfPlace& place) const
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (place[axis] < 0 || place[axis] > 2 * _counts[axis])
            return false;
    if (!_data)
        return true;
    const glm::dvec3 p = fieldPoint(place);
    return glm::all(glm::greaterThanEqual(p, _data->low - _slack)) &&
           glm::all(glm::lessThanEqual(p, _data->high + _slack));
}

core::Box FieldGrid::boxBetween(const HalfPlace& low, const HalfPlace& high) const
{
    core::Box box;
    for (unsigned corner = 0; corner < 8; ++corner)
        box.include(fieldPoint(HalfPlace{
            (corner & 1U) != 0 ? high[0] : low[0],
            (corner & 2U) != 0 ? high[1] : low[1],
            (corner & 4U) != 0 ? high[2] : low[2]}));
    return {box.low - _slack, box.high + _slack};
}

bool FieldGrid::hasDataBetween(const HalfPlace& low, const HalfPlace& high) const
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (low[axis] < 0 || high[axis] > 2 * _counts[axis])
            return false;
    if (!_data)
        return true;
    // a little wider than what `hasData` takes: a place at the very border can't be told from here
    const core::Box box = boxBetween(low, high);
    return glm::all(glm::greaterThanEqual(box.low, _data->low - _slack)) &&
           glm::all(glm::lessThanEqual(box.high, _data->high + _slack));
}

bool FieldGrid::hasNoneBetween(const HalfPlace& low, const HalfPlace& high) const
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (high[axis] < 0 || low[axis] > 2 * _counts[axis])
            return true;
    if (!_data)
        return false;
    const core::Box box = boxBetween(low, high);
    return glm::any(glm::lessThan(box.high, _data->low - _slack)) ||
           glm::any(glm::greaterThan(box.low, _data->high + _slack));
}

glm::dvec3 FieldGrid::borderNormal(const HalfPlace& beyond) const
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        glm::dvec3 normal(0);
        normal[static_cast<glm::length_t>(axis)] = beyond[axis] < 0 ? -1 : 1;
        if (beyond[axis] < 0 || beyond[axis] > 2 * _counts[axis])
            return normal;
    }
    const glm::dvec3 p = fieldPoint(beyond);
    glm::dvec3 outward(0);
    double most = 0;
    for (glm::length_t axis = 0; axis < 3; ++axis)
        for (const bool up : {false, true}) {
            const double over = up ? p[axis] - _data->high[axis] : _data->low[axis] - p[axis];
            if (over > most) {
                most = over;
                outward = glm::dvec3(0);
                outward[axis] = up ? 1 : -1;
            }
        }
    return glm::normalize(_worldFromGradient * outward);
}

core::Interval FieldGrid::bounds(const HalfPlace& low, const HalfPlace& high) const
{
    HalfPlace first = low;
    HalfPlace last = high;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = std::max(first[axis], std::int64_t{0});
        last[axis] = std::min(last[axis], 2 * _counts[axis]);
    }
    return _field.bounds(boxBetween(first, last), {_radius, _radius});
}

fields::SampleBatch FieldGrid::batch(FieldPoints& points) const
{
    if (_radius > 0)
        points.radius.assign(points.size(), _radius);
    else
        points.radius.clear();
    return {points.x, points.y, points.z, points.radius};
}

void FieldGrid::sampleGrid(
    const HalfPlace& low,
    const HalfPlace& high,
    FieldPoints& points,
    std::vector<float>& values) const
{
    if (_scale) {
        fields::SampleGrid grid;
        // one grid for all middles and one for all corners, whatever part is asked for
        HalfPlace start{};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto i = static_cast<glm::length_t>(axis);
            start[axis] = low[axis] & 1;
            grid.first[i] = (low[axis] - start[axis]) / 2;
            grid.count[i] = (high[axis] - low[axis]) / 2 + 1;
        }
        grid.origin = fieldPoint(start);
        grid.spacing = *_scale * 2 * _half;
        grid.radius = _radius;
        values.resize(grid.size());
        _field.sampleGrid(grid, values);
        return;
    }
    points.clear();
    HalfPlace place{};
    for (place[2] = low[2]; place[2] <= high[2]; place[2] += 2)
        for (place[1] = low[1]; place[1] <= high[1]; place[1] += 2)
            for (place[0] = low[0]; place[0] <= high[0]; place[0] += 2)
                points.add(fieldPoint(place));
    sample(points, values);
}

void FieldGrid::sample(FieldPoints& points, std::vector<float>& values) const
{
    values.resize(points.size());
    if (!values.empty())
        _field.sample(batch(points), values);
}

void FieldGrid::descents(FieldPoints& points, std::vector<glm::dvec3>& normals) const
{
    const std::size_t size = points.size();
    normals.resize(size);
    if (size == 0)
        return;
    std::vector<double> gradients(3 * size);
    const std::span<double> all(gradients);
    const fields::GradientSpans spans{
        all.first(size), all.subspan(size, size), all.subspan(2 * size)};
    _field.gradient(batch(points), spans);
    for (std::size_t i = 0; i < size; ++i) {
        const glm::dvec3 down =
            -(_worldFromGradient * glm::dvec3(spans.x[i], spans.y[i], spans.z[i]));
        const double length = std::sqrt(glm::dot(down, down));
        const bool usable = length > 0 && std::isfinite(length);
        normals[i] = usable ? down / length : glm::dvec3(0);
    }
}

void FieldGrid::attributes(FieldPoints& points, std::vector<std::uint32_t>& words) const
{
    words.resize(points.size());
    if (!words.empty())
        _field.attributes(batch(points), words);
}

double FieldGrid::above(float value) const
{
    const double difference = std::isnan(value) ? -kHuge : static_cast<double>(value) - _isovalue;
    return std::clamp(difference, -kHuge, kHuge);
}

} // namespace isofront::voxels
