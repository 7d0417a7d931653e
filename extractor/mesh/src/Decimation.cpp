#include "Decimation.h"

#include "TriangleShape.h"

#include <isofront/core/Hash.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::extractor {

namespace {

/// Vertices with more triangles than this stay.
constexpr std::size_t kMostTriangles = 256;

class Decimator {
public:
    Decimator(RoughMesh& mesh, const DecimationSettings& settings, DecimationScratch& scratch)
        : _mesh(mesh), _settings(settings), _s(scratch),
          _limit(settings.tolerance * settings.tolerance), _furthest(4 * _limit)
    {
    }

    void run(const CellFrame& frame)
    {
        setUp(frame);
        std::uint64_t draw = 0;
        while (!_s.active.empty()) {
            std::uint16_t chosen = kNoVertex;
            for (int i = 0; i < _settings.choices && !_s.active.empty(); ++i) {
                const std::uint64_t word = core::hashCombined(_settings.seed, draw++);
                const std::size_t place = ((word >> 32U) * _s.active.size()) >> 32U;
                const std::uint16_t vertex = _s.active[place];
                if (!_s.best[vertex].known)
                    evaluate(vertex);
                if (_s.best[vertex].target == kNoVertex)
                    retire(vertex);
                else if (chosen == kNoVertex || _s.best[vertex].error < _s.best[chosen].error)
                    chosen = vertex;
            }
            if (chosen != kNoVertex)
                collapse(chosen, _s.best[chosen].target);
        }
        dropTriangles();
    }

private:
    using Collapse = DecimationScratch::Collapse;
    static constexpr std::uint32_t kNone = DecimationScratch::kNone;

    /// The other two vertices of a corner's triangle, in its order.
    [[nodiscard]] std::uint16_t after(std::uint32_t corner) const
    {
        return _mesh.indices[corner % 3 == 2 ? corner - 2 : corner + 1];
    }
    [[nodiscard]] std::uint16_t before(std::uint32_t corner) const
    {
        return _mesh.indices[corner % 3 == 0 ? corner + 2 : corner - 1];
    }

    void setUp(const CellFrame& frame)
    {
        const std::size_t count = _mesh.vertices.size();
        const auto& indices = _mesh.indices;
        _s.position.resize(count);
        for (std::size_t i = 0; i < count; ++i)
            _s.position[i] = frame.local(_mesh.vertices[i].position) - CellFrame::kMiddle;
        _s.quadric.assign(count, {});
        _s.firstCorner.assign(count, kNone);
        _s.nextCorner.resize(indices.size());
        _s.gone.assign(indices.size() / 3, 0);
        for (std::uint32_t corner = 0; corner < indices.size(); ++corner)
            link(corner);
        for (std::size_t i = 0; i < indices.size(); i += 3) {
            Quadric plane;
            plane.addTriangle(
                _s.position[indices[i]], _s.position[indices[i + 1]], _s.position[indices[i + 2]]);
            for (std::size_t k = 0; k < 3; ++k)
                _s.quadric[indices[i + k]].add(plane);
        }
        _s.own.resize(count);
        for (std::size_t i = 0; i < count; ++i)
            _s.own[i] = _s.quadric[i].at(_s.position[i]);
        _s.firstHeld.assign(indices.size() / 3, kNoVertex);
        _s.nextHeld.assign(count, kNoVertex);
        _s.best.assign(count, {});
        if (_s.mark.size() < count)
            _s.mark.resize(count, 0);
        _s.active.clear();
        _s.activeAt.assign(count, kNoVertex);
        for (std::size_t i = 0; i < count; ++i)
            if (!_mesh.vertices[i].isLocked())
                activate(static_cast<std::uint16_t>(i));
    }

    void link(std::uint32_t corner)
    {
        std::uint32_t& first = _s.firstCorner[_mesh.indices[corner]];
        _s.nextCorner[corner] = first;
        first = corner;
    }

    /// Calls a function for each corner of a vertex, and forgets those of triangles that are gone.
    template <typename Function>
    void forEachCorner(std::uint16_t vertex, Function&& function)
    {
        std::uint32_t* place = &_s.firstCorner[vertex];
        while (*place != kNone) {
            const std::uint32_t corner = *place;
            if (_s.gone[corner / 3] != 0) {
                *place = _s.nextCorner[corner];
                continue;
            }
            function(corner);
            place = &_s.nextCorner[corner];
        }
    }

    void activate(std::uint16_t vertex)
    {
        _s.best[vertex].known = false;
        if (_s.activeAt[vertex] != kNoVertex)
            return;
        _s.activeAt[vertex] = static_cast<std::uint16_t>(_s.active.size());
        _s.active.push_back(vertex);
    }

    void retire(std::uint16_t vertex)
    {
        const std::uint16_t place = _s.activeAt[vertex];
        const std::uint16_t last = _s.active.back();
        _s.active[place] = last;
        _s.activeAt[last] = place;
        _s.activeAt[vertex] = kNoVertex;
        _s.active.pop_back();
    }

    /// @return how many triangles a vertex has; only the first kMostTriangles are gathered
    std::size_t gatherRing(std::uint16_t vertex)
    {
        std::size_t count = 0;
        forEachCorner(vertex, [&](std::uint32_t corner) {
            if (count < kMostTriangles) {
                _ring[count] = {after(corner), before(corner)};
                _triangle[count] = corner / 3;
            }
            ++count;
        });
        return count;
    }

    /// Finds the cheapest legal collapse of a vertex within the tolerance.
    void evaluate(std::uint16_t vertex)
    {
        Collapse& best = _s.best[vertex];
        best = {.error = 0, .target = kNoVertex, .known = true};
        const std::size_t count = gatherRing(vertex);
        if (count > kMostTriangles)
            return;

        // the triangles close up around an unlocked vertex, so each neighbour comes after it once
        const Quadric& quadric = _s.quadric[vertex];
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint16_t target = _ring[i][0];
            const double mine = quadric.at(_s.position[target]);
            // of the vertex alone, too: else a large flat part would hide a small bump
            const double both =
                (mine + _s.own[target]) / (quadric.weight + _s.quadric[target].weight);
            _error[i] = std::max(mine / quadric.weight, both);
        }
        for (;;) {
            std::size_t least = count;
            for (std::size_t i = 0; i < count; ++i)
                if (_error[i] <= _limit && (least == count || _error[i] < _error[least]))
                    least = i;
            if (least == count)
                return;
            if (isLegal(vertex, _ring[least][0], count)) {
                best.error = _error[least];
                best.target = _ring[least][0];
                return;
            }
            _error[least] = std::numeric_limits<double>::infinity();
        }
    }

    /// @param count  how many triangles the vertex has; their other corners are in the ring
    bool isLegal(std::uint16_t vertex, std::uint16_t target, std::size_t count)
    {
        // shapes first: that is cheap, and says no most often
        const glm::dvec3& from = _s.position[vertex];
        const glm::dvec3& to = _s.position[target];
        double worstOld = std::numeric_limits<double>::infinity();
        double worstNew = worstOld;
        for (std::size_t i = 0; i < count; ++i) {
            const auto [a, b] = _ring[i];
            const TriangleShape old(from, _s.position[a], _s.position[b]);
            worstOld = std::min(worstOld, old.squaredQuality());
            if (a == target || b == target)
                continue;
            const TriangleShape turned(to, _s.position[a], _s.position[b]);
            if (!turned.facesLike(old))
                return false;
            if (!turned.isAtLeast(kLeastShape))
                worstNew = std::min(worstNew, turned.squaredQuality());
        }
        if (worstNew < worstOld)
            return false;

        // topology: vertex and target must have no common neighbours but the two across their edge
        const std::uint32_t stamp = ++_s.epoch;
        bool isTetrahedron = false;
        forEachCorner(target, [&](std::uint32_t corner) {
            const std::uint16_t a = after(corner);
            const std::uint16_t b = before(corner);
            _s.mark[a] = stamp;
            _s.mark[b] = stamp;
            for (std::size_t i = 0; i < count && count == 3; ++i)
                isTetrahedron = isTetrahedron || (a == _ring[i][1] && b == _ring[i][0] &&
                                                  a != vertex && b != vertex);
        });
        if (isTetrahedron)
            return false;
        const FeatureMask face = _mesh.vertices[target].feature;
        std::size_t common = 0;
        for (std::size_t i = 0; i < count; ++i) {
            const std::uint16_t neighbour = _ring[i][0];
            if (neighbour == target)
                continue;
            if (_s.mark[neighbour] == stamp)
                ++common;
            else if ((_mesh.vertices[neighbour].feature & face) != 0)
                return false;
        }
        return common == 2;
    }

    /// Calls a function for the vertex and each removed one that its triangles hold.
    template <typename Function>
    void forEachHeld(std::uint16_t vertex, std::size_t count, Function&& function)
    {
        function(vertex);
        for (std::size_t i = 0; i < count; ++i)
            for (std::uint16_t held = _s.firstHeld[_triangle[i]]; held != kNoVertex;) {
                const std::uint16_t next = _s.nextHeld[held];
                function(held);
                held = next;
            }
    }

    /// From a vertex to the triangle that one of the ring becomes by a collapse; infinite if it
    /// goes.
    double squaredDistanceOf(std::uint16_t vertex, std::uint16_t target, std::size_t i) const
    {
        const auto [a, b] = _ring[i];
        if (a == target || b == target)
            return std::numeric_limits<double>::infinity();
        return squaredDistance(
            _s.position[vertex], _s.position[target], _s.position[a], _s.position[b]);
    }

    /// Hands the removed vertices around a vertex, and itself, to near triangles of those that its
    /// collapse leaves. If one is too far from all of them, all stay where they are.
    bool handOver(std::uint16_t vertex, std::uint16_t target, std::size_t count)
    {
        const double closeEnough = _furthest / 16;
        std::size_t likely = 0; // what was held together lies together
        _s.held.clear();
        bool allNear = true;
        forEachHeld(vertex, count, [&](std::uint16_t held) {
            std::size_t nearest = 0;
            double least = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < count && allNear && least > closeEnough; ++k) {
                const std::size_t i = (likely + k) % count;
                const double distance = squaredDistanceOf(held, target, i);
                if (distance < least) {
                    least = distance;
                    nearest = i;
                }
            }
            allNear = allNear && least <= _furthest;
            likely = nearest;
            _s.held.push_back({held, static_cast<std::uint16_t>(nearest)});
        });
        if (!allNear)
            return false;
        for (std::size_t i = 0; i < count; ++i)
            _s.firstHeld[_triangle[i]] = kNoVertex;
        for (const auto& [held, place] : _s.held) {
            _s.nextHeld[held] = _s.firstHeld[_triangle[place]];
            _s.firstHeld[_triangle[place]] = held;
        }
        return true;
    }

    void collapse(std::uint16_t vertex, std::uint16_t target)
    {
        retire(vertex);
        if (!handOver(vertex, target, gatherRing(vertex)))
            return; // until something around it changes
        std::uint32_t corner = _s.firstCorner[vertex];
        _s.firstCorner[vertex] = kNone;
        while (corner != kNone) {
            const std::uint32_t next = _s.nextCorner[corner];
            if (_s.gone[corner / 3] == 0) {
                if (after(corner) == target || before(corner) == target) {
                    _s.gone[corner / 3] = 1;
                } else {
                    _mesh.indices[corner] = target;
                    link(corner);
                }
            }
            corner = next;
        }
        _s.quadric[target].add(_s.quadric[vertex]);
        _s.own[target] = _s.quadric[target].at(_s.position[target]);
        // whose best collapse may be another now
        const auto touch = [&](std::uint16_t v) {
            if (!_mesh.vertices[v].isLocked())
                activate(v);
        };
        touch(target);
        forEachCorner(target, [&](std::uint32_t c) {
            touch(after(c));
            touch(before(c));
        });
    }

    void dropTriangles()
    {
        auto& indices = _mesh.indices;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < indices.size(); i += 3) {
            if (_s.gone[i / 3] != 0)
                continue;
            for (std::size_t k = 0; k < 3; ++k)
                indices[kept + k] = indices[i + k];
            kept += 3;
        }
        indices.resize(kept);
        _mesh.compact();
    }

    RoughMesh& _mesh;
    const DecimationSettings& _settings;
    DecimationScratch& _s;
    double _limit;    ///< squared: of the mean
    double _furthest; ///< squared: of a removed vertex from its triangle
    /// Of the vertex that is being looked at: the two vertices after and before it in each of its
    /// triangles, and the error of collapsing into the first.
    std::array<std::array<std::uint16_t, 2>, kMostTriangles> _ring;
    std::array<double, kMostTriangles> _error;
    std::array<std::uint32_t, kMostTriangles> _triangle; ///< which they are
};

} // namespace

void Quadric::addTriangle(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r)
{
    const glm::dvec3 normal = glm::cross(q - p, r - p);
    const double length = glm::length(normal); // twice the area
    if (!(length > 0))
        return;
    const glm::dvec3 n = normal / length;
    const double d = -glm::dot(n, p);
    const double area = 0.5 * length;
    c[0] += area * n.x * n.x;
    c[1] += area * 2 * n.x * n.y;
    c[2] += area * 2 * n.x * n.z;
    c[3] += area * n.y * n.y;
    c[4] += area * 2 * n.y * n.z;
    c[5] += area * n.z * n.z;
    c[6] += area * 2 * n.x * d;
    c[7] += area * 2 * n.y * d;
    c[8] += area * 2 * n.z * d;
    c[9] += area * d * d;
    weight += area;
}

void Quadric::add(const Quadric& other)
{
    for (std::size_t i = 0; i < c.size(); ++i)
        c[i] += other.c[i];
    weight += other.weight;
}

double Quadric::at(const glm::dvec3& p) const
{
    const double value = p.x * (c[0] * p.x + c[1] * p.y + c[2] * p.z + c[6]) +
                         p.y * (c[3] * p.y + c[4] * p.z + c[7]) + p.z * (c[5] * p.z + c[8]) + c[9];
    return std::max(value, 0.0);
}

void decimate(
    RoughMesh& mesh,
    const CellFrame& frame,
    const DecimationSettings& settings,
    DecimationScratch& scratch)
{
    Decimator(mesh, settings, scratch).run(frame);
}

} // namespace isofront::extractor
