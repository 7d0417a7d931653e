#include "isofront/bench/TrueSurface.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace isofront::bench {

namespace {

constexpr std::size_t kBatch = 512;
constexpr int kNewtonSteps = 12;
constexpr int kTangentRounds = 3;
constexpr int kCorrections = 3; // Newton steps after each step in the tangent plane
constexpr int kScanSteps = 16;  // a side
constexpr int kHalvings = 32;
constexpr double kPrecision = 1e-6; // of the reach

struct Value {
    double value = 0;         // minus the isovalue
    glm::dvec3 gradient{0.0}; // [field units / world]
};

} // namespace

/// Points that are worked on together, because fields are sampled in batches.
class TrueSurface::Batch {
public:
    Batch(const TrueSurface& surface, double reach) : _surface(surface), _reach(reach) {}

    void project(std::span<const glm::dvec3> points, std::span<Landing> landings)
    {
        std::vector<glm::dvec3> at(points.begin(), points.end());
        std::vector<bool> isDone = descend(points, at, kNewtonSteps);
        scan(points, at, isDone);
        for (int round = 0; round < kTangentRounds; ++round)
            slide(points, at, isDone);
        std::vector<Value> values = evaluated(at);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double length = glm::length(values[i].gradient);
            landings[i].found = isDone[i] && length > 0 && std::isfinite(length) &&
                                glm::distance(points[i], at[i]) <= _reach;
            landings[i].point = at[i];
            if (landings[i].found)
                landings[i].normal = -values[i].gradient / length;
        }
    }

private:
    std::vector<Value> evaluated(const std::vector<glm::dvec3>& points)
    {
        const std::size_t count = points.size();
        std::vector<double> x(count), y(count), z(count), gx(count), gy(count), gz(count);
        std::vector<float> values(count);
        for (std::size_t i = 0; i < count; ++i) {
            const glm::dvec3 p = _surface._fieldFromWorld.point(points[i]);
            x[i] = p.x;
            y[i] = p.y;
            z[i] = p.z;
        }
        const std::vector<double> radius(
            _surface._filterRadius > 0 ? count : 0, _surface._filterRadius);
        _surface._field->sampleWithGradient({x, y, z, radius}, values, {gx, gy, gz});
        const glm::dmat3 normalMatrix = _surface._worldFromField.normalMatrix();
        std::vector<Value> result(count);
        for (std::size_t i = 0; i < count; ++i)
            result[i] = {
                double(values[i]) - _surface._isovalue,
                normalMatrix * glm::dvec3(gx[i], gy[i], gz[i])};
        return result;
    }

    /// True where the value is as near to the isovalue as floats can tell, or as we need.
    [[nodiscard]] bool isOn(const Value& v) const
    {
        const double rounding = 1.2e-7 * std::abs(_surface._isovalue);
        return std::abs(v.value) <= kPrecision * _reach * glm::length(v.gradient) + rounding;
    }

    /// Newton steps, each point until it is on the surface or out of reach.
    std::vector<bool>
    descend(std::span<const glm::dvec3> from, std::vector<glm::dvec3>& at, int steps)
    {
        std::vector<bool> isDone(at.size(), false);
        std::vector<std::size_t> open(at.size());
        for (std::size_t i = 0; i < open.size(); ++i)
            open[i] = i;
        for (int step = 0; step <= steps && !open.empty(); ++step) {
            std::vector<glm::dvec3> places;
            for (const std::size_t i : open)
                places.push_back(at[i]);
            const std::vector<Value> values = evaluated(places);
            std::vector<std::size_t> next;
            for (std::size_t k = 0; k < open.size(); ++k) {
                const std::size_t i = open[k];
                const double squared = glm::dot(values[k].gradient, values[k].gradient);
                if (!(squared > 0) || !std::isfinite(squared) || !std::isfinite(values[k].value))
                    continue;
                if (isOn(values[k])) {
                    isDone[i] = true;
                    continue;
                }
                glm::dvec3 move = -values[k].value / squared * values[k].gradient;
                // half the reach at most: a flat spot sends far away
                move *= std::min(1.0, 0.5 * _reach / glm::length(move));
                at[i] += move;
                if (glm::distance(at[i], from[i]) <= 1.5 * _reach)
                    next.push_back(i);
            }
            open = std::move(next);
        }
        return isDone;
    }

    /// Moves what is on the surface towards the point it belongs to, along the surface.
    void slide(
        std::span<const glm::dvec3> from,
        std::vector<glm::dvec3>& at,
        const std::vector<bool>& isDone)
    {
        const std::vector<Value> values = evaluated(at);
        std::vector<glm::dvec3> moved = at;
        for (std::size_t i = 0; i < at.size(); ++i) {
            const double length = glm::length(values[i].gradient);
            if (!isDone[i] || !(length > 0))
                continue;
            const glm::dvec3 normal = values[i].gradient / length;
            const glm::dvec3 offset = from[i] - at[i];
            moved[i] += offset - glm::dot(offset, normal) * normal;
        }
        const std::vector<bool> isOnAgain = descend(from, moved, kCorrections);
        for (std::size_t i = 0; i < at.size(); ++i)
            if (isDone[i] && isOnAgain[i] &&
                glm::distance(from[i], moved[i]) < glm::distance(from[i], at[i]))
                at[i] = moved[i];
    }

    /// Looks along the gradient, both ways, for the nearest change of sign.
    void
    scan(std::span<const glm::dvec3> from, std::vector<glm::dvec3>& at, std::vector<bool>& isDone)
    {
        std::vector<std::size_t> open;
        std::vector<glm::dvec3> places;
        for (std::size_t i = 0; i < at.size(); ++i)
            if (!isDone[i]) {
                open.push_back(i);
                places.push_back(from[i]);
            }
        if (open.empty())
            return;
        const std::vector<Value> start = evaluated(places);
        for (std::size_t k = 0; k < open.size(); ++k) {
            const double length = glm::length(start[k].gradient);
            const glm::dvec3 along = length > 0 && std::isfinite(length)
                                         ? start[k].gradient / length
                                         : glm::dvec3(0, 0, 1);
            std::vector<glm::dvec3> line;
            for (int s = -kScanSteps; s <= kScanSteps; ++s)
                line.push_back(from[open[k]] + s * _reach / kScanSteps * along);
            const std::vector<Value> values = evaluated(line);
            int best = 2 * kScanSteps; // the bracket nearest to the middle
            for (int s = 0; s < 2 * kScanSteps; ++s)
                if ((values[std::size_t(s)].value >= 0) !=
                        (values[std::size_t(s) + 1].value >= 0) &&
                    (best == 2 * kScanSteps || std::abs(2 * s + 1 - 2 * kScanSteps) <
                                                   std::abs(2 * best + 1 - 2 * kScanSteps)))
                    best = s;
            if (best == 2 * kScanSteps)
                continue;
            glm::dvec3 low = line[std::size_t(best)];
            glm::dvec3 high = line[std::size_t(best) + 1];
            const bool lowIsInside = values[std::size_t(best)].value >= 0;
            for (int halving = 0; halving < kHalvings; ++halving) {
                const glm::dvec3 middle = 0.5 * (low + high);
                (evaluated({middle})[0].value >= 0) == lowIsInside ? low = middle : high = middle;
            }
            at[open[k]] = 0.5 * (low + high);
            isDone[open[k]] = true;
        }
    }

    const TrueSurface& _surface;
    double _reach;
};

TrueSurface::TrueSurface(
    std::shared_ptr<const fields::Field> field,
    double isovalue,
    core::Affine worldFromField,
    double filterRadius)
    : _field(std::move(field)), _isovalue(isovalue), _worldFromField(worldFromField),
      _fieldFromWorld(worldFromField.inverse()), _filterRadius(filterRadius)
{
}

std::vector<TrueSurface::Landing>
TrueSurface::project(std::span<const glm::dvec3> points, double reach, core::Jobs& jobs) const
{
    std::vector<Landing> landings(points.size());
    const std::size_t batches = (points.size() + kBatch - 1) / kBatch;
    jobs.parallelFor(batches, [&](std::size_t b) {
        const std::size_t first = b * kBatch;
        const std::size_t count = std::min(kBatch, points.size() - first);
        Batch(*this, reach)
            .project(points.subspan(first, count), std::span(landings).subspan(first, count));
    });
    return landings;
}

} // namespace isofront::bench
