#include "EdgeAlignment.h"

#include "TriangleShape.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::extractor {

namespace {

constexpr std::uint32_t kNone = AlignmentScratch::kNone;
/// Sides are looked at so often on average at most; two is usual.
constexpr std::size_t kMostLooks = 8;
/// A flip must lower the error by so much, so that no two edges change places for ever.
constexpr double kGain = 0.999;
/// Curvature of the surface that stands for a flat one, times the axis step: far below what normals
/// of 16 bits can tell.
constexpr double kFlat = 2e-3;
/// How much of it the normals' turning adds, since what they tell of the surface between them is
/// then worth less.
constexpr double kDoubt = 0.5;

class Aligner {
public:
    Aligner(
        RoughMesh& mesh,
        const std::vector<glm::dvec3>& normals,
        double axisStep,
        AlignmentScratch& scratch)
        : _mesh(mesh), _normals(normals), _s(scratch), _perStep(1 / axisStep)
    {
    }

    void run(const CellFrame& frame)
    {
        setUp(frame);
        const std::size_t most = kMostLooks * _mesh.indices.size();
        for (std::size_t i = 0; i < _s.queue.size() && i < most; ++i) {
            const std::uint32_t corner = _s.queue[i];
            _s.waiting[corner] = 0;
            flipAt(corner);
        }
    }

private:
    using Side = AlignmentScratch::Side;

    void setUp(const CellFrame& frame)
    {
        const std::size_t count = _mesh.vertices.size();
        const auto corners = static_cast<std::uint32_t>(_mesh.indices.size());
        _s.position.resize(count);
        for (std::size_t i = 0; i < count; ++i)
            _s.position[i] = frame.local(_mesh.vertices[i].position) - CellFrame::kMiddle;
        _s.firstCorner.assign(count, kNone);
        _s.nextCorner.resize(corners);
        _s.across.assign(corners, kNone);
        _s.side.resize(corners);
        _s.waiting.assign(corners, 0);
        _s.queue.clear();
        for (std::uint32_t corner = 0; corner < corners; ++corner) {
            // the side has been met in the other direction, or it will be
            const std::uint16_t from = _mesh.indices[corner];
            const std::uint16_t to = _mesh.indices[next(corner)];
            const std::uint32_t other = cornerOf(to, from);
            link(corner);
            if (other == kNone) {
                _s.side[corner] = sideOf(from, to);
                continue;
            }
            _s.side[corner] = _s.side[other];
            _s.across[corner] = other;
            _s.across[other] = corner;
            push(corner);
        }
        _s.error.resize(corners / 3);
        for (std::uint32_t triangle = 0; triangle < corners / 3; ++triangle)
            _s.error[triangle] = errorOf(triangle);
    }

    void link(std::uint32_t corner)
    {
        std::uint32_t& first = _s.firstCorner[_mesh.indices[corner]];
        _s.nextCorner[corner] = first;
        first = corner;
    }
    void unlink(std::uint32_t corner)
    {
        std::uint32_t* place = &_s.firstCorner[_mesh.indices[corner]];
        while (*place != corner)
            place = &_s.nextCorner[*place];
        *place = _s.nextCorner[corner];
    }
    static std::uint32_t next(std::uint32_t corner)
    {
        return corner % 3 == 2 ? corner - 2 : corner + 1;
    }
    void push(std::uint32_t corner)
    {
        if (_s.across[corner] == kNone || _s.waiting[corner] != 0 ||
            _s.waiting[_s.across[corner]] != 0)
            return;
        _s.waiting[corner] = 1;
        _s.queue.push_back(corner);
    }
    void join(std::uint32_t corner, std::uint32_t other)
    {
        _s.across[corner] = other;
        if (other != kNone)
            _s.across[other] = corner;
    }

    /// The corner of `from` in the triangle in which `to` comes after it.
    [[nodiscard]] std::uint32_t cornerOf(std::uint16_t from, std::uint16_t to) const
    {
        std::uint32_t corner = _s.firstCorner[from];
        while (corner != kNone && _mesh.indices[next(corner)] != to)
            corner = _s.nextCorner[corner];
        return corner;
    }

    /// Flips the edge from a corner's vertex to the next if that is allowed and pays.
    void flipAt(std::uint32_t corner)
    {
        const std::uint32_t across = _s.across[corner];
        if (across == kNone)
            return; // on the border of the cell
        const std::uint32_t second = next(corner);
        const std::uint32_t third = next(second);
        const std::uint32_t other = next(across);
        const std::uint32_t last = next(other);
        const std::uint32_t one = corner / 3;
        const std::uint32_t two = across / 3;
        const std::uint16_t a = _mesh.indices[corner];
        const std::uint16_t b = _mesh.indices[second];
        const std::uint16_t c = _mesh.indices[third];
        const std::uint16_t d = _mesh.indices[last];
        const auto& vertices = _mesh.vertices;
        if ((vertices[c].feature & vertices[d].feature) != 0 || vertices[a].cap ||
            vertices[b].cap || vertices[c].cap || vertices[d].cap)
            return;
        const TriangleShape adc = shape(a, d, c);
        const TriangleShape dbc = shape(d, b, c);
        const Side diagonal = sideOf(d, c);
        const double errorOne = error(adc, _s.side[other], diagonal, _s.side[third]);
        const double errorTwo = error(dbc, _s.side[last], _s.side[second], diagonal);
        if (!(errorOne + errorTwo < kGain * (_s.error[one] + _s.error[two])))
            return;
        const TriangleShape abc = shape(a, b, c);
        const TriangleShape bad = shape(b, a, d);
        if (!adc.facesLike(abc) || !adc.facesLike(bad) || !dbc.facesLike(abc) ||
            !dbc.facesLike(bad))
            return;
        const double worst = std::min(adc.squaredQuality(), dbc.squaredQuality());
        if ((!adc.isAtLeast(kLeastShape) || !dbc.isAtLeast(kLeastShape)) &&
            worst < std::min(abc.squaredQuality(), bad.squaredQuality()))
            return;
        if (cornerOf(c, d) != kNone || cornerOf(d, c) != kNone)
            return;

        // a, b, c and b, a, d become a, d, c and b, c, d
        unlink(second);
        _mesh.indices[second] = d;
        link(second);
        unlink(other);
        _mesh.indices[other] = c;
        link(other);
        const std::uint32_t beyondOne = _s.across[second];
        join(corner, _s.across[other]);
        join(across, beyondOne);
        join(second, other);
        _s.side[corner] = _s.side[other];
        _s.side[across] = _s.side[second];
        _s.side[second] = diagonal;
        _s.side[other] = diagonal;
        _s.error[one] = errorOne;
        _s.error[two] = errorTwo;
        for (const std::uint32_t changed : {corner, third, across, last})
            push(changed);
    }

    [[nodiscard]] TriangleShape shape(std::uint16_t a, std::uint16_t b, std::uint16_t c) const
    {
        return {_s.position[a], _s.position[b], _s.position[c]};
    }
    [[nodiscard]] Side sideOf(std::uint16_t from, std::uint16_t to) const
    {
        const glm::dvec3 along = _s.position[to] - _s.position[from];
        const glm::dvec3 turn = _normals[to] - _normals[from];
        return {glm::dot(turn, along), glm::dot(along, along), glm::dot(turn, turn)};
    }
    [[nodiscard]] double errorOf(std::uint32_t triangle) const
    {
        const std::uint32_t corner = 3 * triangle;
        return error(
            shape(_mesh.indices[corner], _mesh.indices[corner + 1], _mesh.indices[corner + 2]),
            _s.side[corner],
            _s.side[corner + 1],
            _s.side[corner + 2]);
    }

    /// The area of a triangle times the sum of its sides' squared errors.
    [[nodiscard]] double
    error(const TriangleShape& shape, const Side& p, const Side& q, const Side& r) const
    {
        const double bent = p.bend * p.bend + q.bend * q.bend + r.bend * r.bend;
        const double round = p.squared * p.squared + q.squared * q.squared + r.squared * r.squared;
        const double flat = _perStep * (kFlat + kDoubt * (p.turn + q.turn + r.turn));
        return std::sqrt(shape.squaredNormal) * (bent + flat * flat * round);
    }

    RoughMesh& _mesh;
    const std::vector<glm::dvec3>& _normals;
    AlignmentScratch& _s;
    double _perStep; ///< one over the axis step [1 / cell unit]
};

} // namespace

void alignEdges(
    RoughMesh& mesh,
    const CellFrame& frame,
    const std::vector<glm::dvec3>& normals,
    double axisStep,
    AlignmentScratch& scratch)
{
    Aligner(mesh, normals, axisStep, scratch).run(frame);
}

} // namespace isofront::extractor
