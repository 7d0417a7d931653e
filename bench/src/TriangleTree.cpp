// Nearest point of a triangle after C. Ericson, "Real-Time Collision Detection" (2005), section
// 5.1.5; segment against triangle after T. Moeller and B. Trumbore, "Fast, minimum storage
// ray/triangle intersection" (1997).

#include "isofront/bench/TriangleTree.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <utility>

namespace isofront::bench {

namespace {

constexpr std::uint32_t kLeafSize = 4;

double squaredDistance(const core::Box& box, const glm::dvec3& point)
{
    const glm::dvec3 outside = glm::max(glm::max(box.low - point, point - box.high), 0.0);
    return glm::dot(outside, outside);
}

/// The part of from + t * along, t in [begin, end], that lies in the box is not empty.
bool meets(
    const core::Box& box,
    const glm::dvec3& from,
    const glm::dvec3& inverse,
    double begin,
    double end)
{
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        const double a = (box.low[axis] - from[axis]) * inverse[axis];
        const double b = (box.high[axis] - from[axis]) * inverse[axis];
        // a NaN, from a segment that runs in the box's side, decides nothing
        begin = std::max(begin, std::fmin(a, b));
        end = std::min(end, std::fmax(a, b));
    }
    return begin <= end;
}

/// Of a triangle without area, whose regions can't be told apart.
glm::dvec3 nearestOnSides(
    const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    glm::dvec3 best = a;
    for (const auto& [from, to] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}}) {
        const glm::dvec3 side = to - from;
        const double squared = glm::dot(side, side);
        const double t =
            squared > 0 ? std::clamp(glm::dot(point - from, side) / squared, 0.0, 1.0) : 0;
        const glm::dvec3 candidate = from + t * side;
        if (glm::distance(candidate, point) < glm::distance(best, point))
            best = candidate;
    }
    return best;
}

} // namespace

glm::dvec3 nearestOnTriangle(
    const glm::dvec3& point, const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    const glm::dvec3 ab = b - a;
    const glm::dvec3 ac = c - a;
    const glm::dvec3 across = glm::cross(ab, ac);
    const double longest = std::max(glm::dot(ab, ab), glm::dot(ac, ac));
    if (glm::dot(across, across) <= 1e-24 * longest * longest)
        return nearestOnSides(point, a, b, c);
    const double d1 = glm::dot(ab, point - a);
    const double d2 = glm::dot(ac, point - a);
    if (d1 <= 0 && d2 <= 0)
        return a;
    const double d3 = glm::dot(ab, point - b);
    const double d4 = glm::dot(ac, point - b);
    if (d3 >= 0 && d4 <= d3)
        return b;
    const double vc = d1 * d4 - d3 * d2;
    if (vc <= 0 && d1 >= 0 && d3 <= 0)
        return d1 > d3 ? a + d1 / (d1 - d3) * ab : a;
    const double d5 = glm::dot(ab, point - c);
    const double d6 = glm::dot(ac, point - c);
    if (d6 >= 0 && d5 <= d6)
        return c;
    const double vb = d5 * d2 - d1 * d6;
    if (vb <= 0 && d2 >= 0 && d6 <= 0)
        return d2 > d6 ? a + d2 / (d2 - d6) * ac : a;
    const double va = d3 * d6 - d5 * d4;
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
        const double sum = (d4 - d3) + (d5 - d6);
        return sum > 0 ? b + (d4 - d3) / sum * (c - b) : b;
    }
    const double sum = va + vb + vc;
    return a + vb / sum * ab + vc / sum * ac;
}

TriangleTree::TriangleTree(const surface::TriangleMesh& mesh)
    : _mesh(&mesh), _order(mesh.indices.size() / 3)
{
    std::iota(_order.begin(), _order.end(), 0U);
    std::vector<core::Box> boxes(_order.size());
    for (std::uint32_t t = 0; t < _order.size(); ++t)
        for (std::size_t i = 0; i < 3; ++i)
            boxes[t].include(corner(t, i));
    if (!_order.empty())
        build(0, static_cast<std::uint32_t>(_order.size()), boxes);
}

void TriangleTree::build(
    std::uint32_t first, std::uint32_t count, const std::vector<core::Box>& boxes)
{
    const std::size_t at = _nodes.size();
    _nodes.emplace_back();
    core::Box all;
    core::Box centres;
    for (std::uint32_t i = first; i < first + count; ++i) {
        all.include(boxes[_order[i]].low);
        all.include(boxes[_order[i]].high);
        centres.include(boxes[_order[i]].centre());
    }
    _nodes[at].box = all;
    if (count <= kLeafSize) {
        _nodes[at].first = first;
        _nodes[at].count = count;
        return;
    }
    const glm::dvec3 size = centres.size();
    const glm::length_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const std::uint32_t half = count / 2;
    std::nth_element(
        _order.begin() + first,
        _order.begin() + first + half,
        _order.begin() + first + count,
        [&](std::uint32_t a, std::uint32_t b) {
            const double left = boxes[a].low[axis] + boxes[a].high[axis];
            const double right = boxes[b].low[axis] + boxes[b].high[axis];
            return left != right ? left < right : a < b;
        });
    build(first, half, boxes);
    _nodes[at].first = static_cast<std::uint32_t>(_nodes.size());
    build(first + half, count - half, boxes);
}

TriangleTree::Nearest TriangleTree::nearest(const glm::dvec3& point, double reach) const
{
    Nearest best;
    if (_nodes.empty())
        return best;
    double squared = reach * reach;
    struct Entry {
        std::uint32_t node;
        double squared;
    };
    std::array<Entry, 64> stack; // deeper than any tree of 2^32 triangles halved at the median
    std::size_t depth = 0;
    stack[depth++] = {0, squaredDistance(_nodes[0].box, point)};
    while (depth > 0) {
        const Entry entry = stack[--depth];
        if (entry.squared >= squared)
            continue;
        const Node& node = _nodes[entry.node];
        if (node.count == 0) {
            Entry near{entry.node + 1, squaredDistance(_nodes[entry.node + 1].box, point)};
            Entry far{node.first, squaredDistance(_nodes[node.first].box, point)};
            if (far.squared < near.squared)
                std::swap(near, far);
            stack[depth++] = far;
            stack[depth++] = near;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const std::uint32_t t = _order[i];
            const glm::dvec3 candidate =
                nearestOnTriangle(point, corner(t, 0), corner(t, 1), corner(t, 2));
            const glm::dvec3 offset = candidate - point;
            if (const double d = glm::dot(offset, offset); d < squared) {
                squared = d;
                best = {std::sqrt(d), candidate, t};
            }
        }
    }
    return best;
}

bool TriangleTree::isBlocked(const glm::dvec3& from, const glm::dvec3& to, double margin) const
{
    if (_nodes.empty())
        return false;
    const glm::dvec3 along = to - from;
    const glm::dvec3 inverse = 1.0 / along;
    std::array<std::uint32_t, 64> stack;
    std::size_t depth = 0;
    stack[depth++] = 0;
    while (depth > 0) {
        const std::uint32_t at = stack[--depth];
        const Node& node = _nodes[at];
        if (!meets(node.box, from, inverse, margin, 1 - margin))
            continue;
        if (node.count == 0) {
            stack[depth++] = node.first;
            stack[depth++] = at + 1;
            continue;
        }
        for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
            const glm::dvec3& a = corner(_order[i], 0);
            const glm::dvec3 ab = corner(_order[i], 1) - a;
            const glm::dvec3 ac = corner(_order[i], 2) - a;
            const glm::dvec3 p = glm::cross(along, ac);
            const double determinant = glm::dot(ab, p);
            if (determinant == 0)
                continue;
            const double u = glm::dot(from - a, p) / determinant;
            const glm::dvec3 q = glm::cross(from - a, ab);
            const double v = glm::dot(along, q) / determinant;
            const double t = glm::dot(ac, q) / determinant;
            if (u >= 0 && v >= 0 && u + v <= 1 && t > margin && t < 1 - margin)
                return true;
        }
    }
    return false;
}

} // namespace isofront::bench
