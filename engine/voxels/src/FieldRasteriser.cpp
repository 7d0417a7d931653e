// Based on:
// - S. Laine, "A topological approach to voxelization", Computer Graphics Forum 32(4), 2013
// - M. Chajdas, M. Reitinger, R. Westermann, "Scalable rendering for very large meshes", section 3

#include "FieldRasteriser.h"

#include "LinearColour.h"

#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::voxels {

namespace {

using Place = std::array<std::int64_t, 3>;

/// Blocks with no more middles along an edge are sampled whole.
constexpr std::int64_t kBlock = 17;
/// The weight of a surface that only touches a cube: it decides nothing where there is another.
constexpr float kTrace = 1e-12F;

HalfPlace middleOf(const Place& voxel)
{
    return {2 * voxel[0] + 1, 2 * voxel[1] + 1, 2 * voxel[2] + 1};
}

Face faceOf(std::size_t axis, bool up)
{
    return static_cast<Face>(2 * axis + (up ? 1U : 0U));
}

} // namespace

FieldRasteriser::FieldRasteriser() : _linear(linearOfCodes()) {}

bool FieldRasteriser::isOwn(const Place& voxel) const
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (voxel[axis] < _brick.low[axis] || voxel[axis] >= _brick.high[axis])
            return false;
    return true;
}

std::array<std::uint32_t, 3> FieldRasteriser::inChunk(const Place& voxel) const
{
    return {
        static_cast<std::uint32_t>(voxel[0] - _chunk[0]),
        static_cast<std::uint32_t>(voxel[1] - _chunk[1]),
        static_cast<std::uint32_t>(voxel[2] - _chunk[2])};
}

std::uint32_t FieldRasteriser::at(const Place& voxel)
{
    const std::array<std::uint32_t, 3> place = inChunk(voxel);
    return _grid.at(place[0], place[1], place[2]);
}

void FieldRasteriser::run(
    const FieldGrid& grid,
    const Place& chunk,
    const VoxelRange& brick,
    const Settings& settings,
    VoxelList& list,
    Counts& counts)
{
    _field = &grid;
    _settings = settings;
    _counts = &counts;
    _chunk = chunk;
    _grid.begin(grid.isColoured());
    _shown.clear();
    VoxelRange lower;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        _brick.low[axis] = chunk[axis] + brick.low[axis];
        _brick.high[axis] = chunk[axis] + brick.high[axis];
        // a voxel's surface may be found between it and the one below
        lower.low[axis] = _brick.low[axis] - 1;
        lower.high[axis] = _brick.high[axis];
    }
    split(lower);
    finish(list);
}

/// @param lower  voxels of which each is looked at together with the next along each axis
void FieldRasteriser::split(const VoxelRange& lower)
{
    const HalfPlace low = middleOf(lower.low);
    const HalfPlace high = middleOf(lower.high);
    if (_field->hasNoneBetween(low, high))
        return;
    // cubes reach half a voxel further than their middles
    const std::int64_t reach = _settings.separability == Separability::conservative ? 1 : 0;
    const core::Interval values = _field->bounds(
        {low[0] - reach, low[1] - reach, low[2] - reach},
        {high[0] + reach, high[1] + reach, high[2] + reach});
    if (values.high < _field->isovalue())
        return;
    const bool allInside = values.low >= _field->isovalue();
    if (allInside && _field->hasDataBetween(low, high))
        return;
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < 3; ++axis)
        if (lower.high[axis] - lower.low[axis] > lower.high[longest] - lower.low[longest])
            longest = axis;
    const std::int64_t size = lower.high[longest] - lower.low[longest];
    if (size <= kBlock) {
        block(lower, allInside);
        return;
    }
    VoxelRange first = lower;
    VoxelRange second = lower;
    first.high[longest] = lower.low[longest] + (size + 1) / 2;
    second.low[longest] = first.high[longest];
    split(first);
    split(second);
}

void FieldRasteriser::count(const std::vector<float>& values)
{
    _counts->samples += values.size();
    constexpr float kHuge = std::numeric_limits<float>::max() / 4;
    for (const float value : values)
        _counts->sanitised += std::abs(value) <= kHuge ? 0U : 1U;
}

void FieldRasteriser::block(const VoxelRange& lower, bool allInside)
{
    const HalfPlace low = middleOf(lower.low);
    const HalfPlace high = middleOf(lower.high);
    std::size_t size = 1;
    for (std::size_t axis = 0; axis < 3; ++axis)
        size *= static_cast<std::size_t>(lower.high[axis] - lower.low[axis] + 1);
    _states.assign(size, inside);
    if (allInside) {
        _values.assign(size, 0);
    } else {
        _field->sampleGrid(low, high, _points, _values);
        count(_values);
        for (std::size_t i = 0; i < size; ++i)
            _states[i] = _field->isInside(_values[i]) ? inside : outside;
    }
    if (!_field->hasDataBetween(low, high)) {
        std::size_t i = 0;
        HalfPlace place{};
        for (place[2] = low[2]; place[2] <= high[2]; place[2] += 2)
            for (place[1] = low[1]; place[1] <= high[1]; place[1] += 2)
                for (place[0] = low[0]; place[0] <= high[0]; place[0] += 2, ++i)
                    if (!_field->hasData(place))
                        _states[i] = noData;
    }
    findCrossings(lower);
    addCrossings();
    if (_settings.separability == Separability::conservative && !allInside)
        addTouched(lower);
}

void FieldRasteriser::findCrossings(const VoxelRange& lower)
{
    _crossings.clear();
    std::array<std::size_t, 3> step{1, 0, 0};
    for (std::size_t axis = 1; axis < 3; ++axis)
        step[axis] = step[axis - 1] *
                     static_cast<std::size_t>(lower.high[axis - 1] - lower.low[axis - 1] + 1);
    Place voxel{};
    for (voxel[2] = lower.low[2]; voxel[2] < lower.high[2]; ++voxel[2])
        for (voxel[1] = lower.low[1]; voxel[1] < lower.high[1]; ++voxel[1]) {
            std::size_t i = static_cast<std::size_t>(voxel[1] - lower.low[1]) * step[1] +
                            static_cast<std::size_t>(voxel[2] - lower.low[2]) * step[2];
            for (voxel[0] = lower.low[0]; voxel[0] < lower.high[0]; ++voxel[0], ++i)
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const State below = _states[i];
                    const State above = _states[i + step[axis]];
                    if (below == above)
                        continue;
                    Place next = voxel;
                    ++next[axis];
                    const bool owned = isOwn(voxel);
                    const bool ownsNext = isOwn(next);
                    if (!owned && !ownsNext)
                        continue;
                    if (below != noData && above != noData)
                        _crossings.push_back(
                            {voxel,
                             static_cast<std::uint32_t>(axis),
                             below == inside,
                             _field->above(_values[i]),
                             _field->above(_values[i + step[axis]])});
                    else if (below == inside && owned)
                        addWall(voxel, axis, true);
                    else if (above == inside && ownsNext)
                        addWall(next, axis, false);
                }
        }
}

void FieldRasteriser::addCrossings()
{
    if (_crossings.empty())
        return;
    // which of the two cubes: the one on whose side of their common face the sign changes
    _points.clear();
    for (const Crossing& crossing : _crossings) {
        HalfPlace face = middleOf(crossing.voxel);
        ++face[crossing.axis];
        _points.add(_field->fieldPoint(face));
    }
    _field->sample(_points, _values);
    count(_values);
    _hits.clear();
    _points.clear();
    for (std::size_t i = 0; i < _crossings.size(); ++i) {
        const Crossing& crossing = _crossings[i];
        const auto axis = static_cast<glm::length_t>(crossing.axis);
        const double halfway = _field->above(_values[i]);
        const bool isUpper = _field->isInside(_values[i]) == crossing.insideBelow;
        Hit hit{crossing.voxel, faceOf(crossing.axis, crossing.insideBelow)};
        hit.voxel[crossing.axis] += isUpper ? 1 : 0;
        if (!isOwn(hit.voxel))
            continue;
        const double from = isUpper ? halfway : crossing.below;
        const double to = isUpper ? crossing.above : halfway;
        const double share = from == to ? 0.5 : std::clamp(from / (from - to), 0.0, 1.0);
        const HalfPlace middle = middleOf(crossing.voxel);
        glm::dvec3 place(
            static_cast<double>(middle[0]),
            static_cast<double>(middle[1]),
            static_cast<double>(middle[2]));
        place[axis] += (isUpper ? 1 : 0) + share;
        _points.add(_field->fieldPoint(place));
        _hits.push_back(hit);
    }
    _field->descents(_points, _normals);
    if (_field->isColoured())
        _field->attributes(_points, _words);
    for (std::size_t i = 0; i < _hits.size(); ++i) {
        glm::dvec3 normal = _normals[i];
        const auto axis = static_cast<glm::length_t>(_hits[i].outward) / 2;
        if (normal == glm::dvec3(0)) // a step: along the axis is what is known
            normal[axis] = (static_cast<unsigned>(_hits[i].outward) & 1U) != 0 ? 1 : -1;
        add(_hits[i], normal, _field->isColoured() ? _words[i] : 0);
    }
}

void FieldRasteriser::add(const Hit& hit, const glm::dvec3& normal, std::uint32_t word)
{
    // lines along an axis meet a surface as often as its area seen along the axis has unit squares,
    // so each hit stands for as much area as makes the sum over the axes that of the surface
    const auto axis = static_cast<glm::length_t>(hit.outward) / 2;
    const auto area = static_cast<float>(std::abs(normal[axis]));
    const float counted = std::max(area, kTrace);
    WeightedFace sum;
    sum.area = area;
    for (std::size_t i = 0; i < 3; ++i)
        sum.normal[i] = counted * static_cast<float>(normal[static_cast<glm::length_t>(i)]);
    if (_field->isColoured())
        sum.colour = {
            counted * _linear[word & 0xffU],
            counted * _linear[word >> 8U & 0xffU],
            counted * _linear[word >> 16U & 0xffU],
            counted};
    add(at(hit.voxel), sum);
    const std::array<std::uint32_t, 3> place = inChunk(hit.voxel);
    _shown.push_back({packPlace(place[0], place[1], place[2], 0), hit.outward, sum});
}

void FieldRasteriser::add(std::uint32_t voxel, const WeightedFace& part)
{
    _grid.mark(voxel);
    addSurface(_grid.surface(voxel), part);
    if (_field->isColoured())
        addColour(_grid.colour(voxel), part.colour);
}

void FieldRasteriser::addWall(const Place& voxel, std::size_t axis, bool up)
{
    if (!_settings.closed) {
        at(voxel);
        return;
    }
    HalfPlace beyond = middleOf(voxel);
    beyond[axis] += up ? 2 : -2;
    if (_field->isColoured()) {
        _points.clear();
        _points.add(_field->fieldPoint(middleOf(voxel)));
        _field->attributes(_points, _words);
    }
    add({voxel, faceOf(axis, up)},
        _field->borderNormal(beyond),
        _field->isColoured() ? _words[0] : 0);
}

/// Adds the cubes whose corners and middle don't all lie on one side.
void FieldRasteriser::addTouched(const VoxelRange& lower)
{
    const std::array<std::int64_t, 3>& low = lower.low;
    HalfPlace first{};
    HalfPlace last{};
    std::array<std::size_t, 3> step{1, 0, 0};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        first[axis] = 2 * low[axis];
        last[axis] = 2 * lower.high[axis];
        if (axis > 0)
            step[axis] =
                step[axis - 1] * static_cast<std::size_t>(lower.high[axis - 1] - low[axis - 1] + 1);
    }
    _field->sampleGrid(first, last, _points, _corners);
    count(_corners);
    const bool allData = _field->hasDataBetween(first, last);
    _points.clear();
    _hits.clear();
    Place voxel{};
    for (voxel[2] = low[2]; voxel[2] < lower.high[2]; ++voxel[2])
        for (voxel[1] = low[1]; voxel[1] < lower.high[1]; ++voxel[1])
            for (voxel[0] = low[0]; voxel[0] < lower.high[0]; ++voxel[0]) {
                std::size_t i = 0;
                for (std::size_t axis = 0; axis < 3; ++axis)
                    i += static_cast<std::size_t>(voxel[axis] - low[axis]) * step[axis];
                const State middle = _states[i];
                if (middle == noData || !isOwn(voxel))
                    continue;
                bool isTouched = false;
                for (std::size_t corner = 0; corner < 8 && !isTouched; ++corner) {
                    std::size_t at = i;
                    HalfPlace place{};
                    for (std::size_t axis = 0; axis < 3; ++axis) {
                        const std::size_t up = corner >> axis & 1U;
                        at += up * step[axis];
                        place[axis] = 2 * (voxel[axis] + static_cast<std::int64_t>(up));
                    }
                    isTouched = _field->isInside(_corners[at]) != (middle == inside) &&
                                (allData || _field->hasData(place));
                }
                if (!isTouched)
                    continue;
                _hits.push_back({voxel, Face::lowX});
                _points.add(_field->fieldPoint(middleOf(voxel)));
            }
    _field->descents(_points, _normals);
    if (_field->isColoured())
        _field->attributes(_points, _words);
    for (std::size_t i = 0; i < _hits.size(); ++i) {
        WeightedFace trace;
        for (std::size_t axis = 0; axis < 3; ++axis)
            trace.normal[axis] =
                kTrace * static_cast<float>(_normals[i][static_cast<glm::length_t>(axis)]);
        if (_field->isColoured())
            trace.colour = {
                kTrace * _linear[_words[i] & 0xffU],
                kTrace * _linear[_words[i] >> 8U & 0xffU],
                kTrace * _linear[_words[i] >> 16U & 0xffU],
                kTrace};
        add(at(_hits[i].voxel), trace);
    }
}

void FieldRasteriser::finish(VoxelList& list)
{
    std::vector<std::uint32_t> mixed; // by order
    const auto take = [&](std::uint32_t which, std::uint32_t place, bool isCrossed) {
        const WeightedSurface& surface = _grid.surface(which);
        const WeightedVoxel voxel{place | (isCrossed ? 0U : kWall), surface.normal, surface.area};
        list.voxels.push_back(voxel);
        if (_field->isColoured())
            list.colours.push_back(_grid.colour(which));
        if (isCrossed && isMixed(voxel))
            mixed.push_back(voxel.order());
    };
    for (std::uint32_t layers = 0; layers < VoxelGrid::kTakes; ++layers)
        _grid.take(layers, false, take);
    if (mixed.empty())
        return;
    const std::size_t first = list.faces.size();
    for (const std::uint32_t order : mixed)
        list.faces.push_back({order, {}});
    for (const Shown& shown : _shown) {
        const auto found = std::ranges::lower_bound(mixed, shown.order);
        if (found == mixed.end() || *found != shown.order)
            continue;
        WeightedFaces& faces = list.faces[first + static_cast<std::size_t>(found - mixed.begin())];
        addAttributes(faces.faces[static_cast<std::size_t>(shown.face)], shown.attributes);
    }
}

} // namespace isofront::voxels
