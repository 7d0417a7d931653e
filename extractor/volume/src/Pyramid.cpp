#include "Pyramid.h"

namespace isofront::volume::detail {

namespace {

/// The weighted mean of those values that are finite, NaN if there are none.
double meanOfFinite(const std::array<double, 5>& weights, const std::array<double, 5>& values)
{
    double sum = 0;
    double total = 0;
    for (std::size_t i = 0; i < 5; ++i) {
        if (weights[i] <= 0 || !std::isfinite(values[i]))
            continue;
        sum += weights[i] * values[i];
        total += weights[i];
    }
    return total > 0 ? sum / total : std::numeric_limits<double>::quiet_NaN();
}

double weightedSum(const std::array<double, 5>& w, double a, double b, double c, double d, double e)
{
    return w[0] * a + w[1] * b + w[2] * c + w[3] * d + w[4] * e;
}

} // namespace

LevelFilter::LevelFilter(const glm::ivec3& voxels, int level, bool hasGaps) : _hasGaps(hasGaps)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        _fine[axis] = LevelAxis(voxels[axis], level - 1).nodes;
        _coarse[axis] = LevelAxis(voxels[axis], level).nodes;
        for (int node = 0; node < _coarse[axis]; ++node)
            _taps[axis].push_back(filterTaps(voxels[axis], level, node));
    }
    for (std::vector<double>& row : _rows)
        row.resize(static_cast<std::size_t>(_fine.x));
    _mixedRow.resize(static_cast<std::size_t>(_fine.x));
}

void LevelFilter::mixRows(
    const std::array<double, 5>& weights,
    const std::array<const double*, 5>& rows,
    std::size_t width,
    double* out) const
{
    const auto [a, b, c, d, e] = rows;
    if (!_hasGaps) {
        const std::array<double, 5> w = weights;
        for (std::size_t i = 0; i < width; ++i)
            out[i] = weightedSum(w, a[i], b[i], c[i], d[i], e[i]);
        return;
    }
    for (std::size_t i = 0; i < width; ++i)
        out[i] = meanOfFinite(weights, {a[i], b[i], c[i], d[i], e[i]});
}

void LevelFilter::filterRow(const double* fine, double* out) const
{
    const int last = _fine.x - 1;
    for (int x = 0; x < _coarse.x; ++x) {
        const FilterTaps& taps = _taps[0][static_cast<std::size_t>(x)];
        const int c = taps.centre;
        const auto at = [&](int i) { return fine[std::clamp(i, 0, last)]; };
        if (_hasGaps)
            out[x] = meanOfFinite(taps.weight, {at(c - 2), at(c - 1), at(c), at(c + 1), at(c + 2)});
        else
            out[x] = weightedSum(taps.weight, at(c - 2), at(c - 1), at(c), at(c + 1), at(c + 2));
    }
}

} // namespace isofront::volume::detail
