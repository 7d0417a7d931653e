#include "EdgeAlignment.h"

#include "TriangleShape.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::extractor {

namespace {

constexpr std::uint32_t kNone = 0xffffffffU;
/// Rounds over all edges; later ones look only at what has changed, and find little.
constexpr int kRounds = 6;
/// A flip must lower the error by so much, so that no two edges change places for ever.
constexpr double kGain = 0.999;
/// Curvature of the surface that stands for a flat one, times the axis step: far below what normals
/// of 16 bits can tell.
constexpr double kFlat = 2e-3;

class Aligner {
public:
    Aligner(
        RoughMesh& mesh,
        const std::vector<glm::dvec3>& normals,
        double axisStep,
        AlignmentScratch& scratch)
        : _mesh(mesh), _normals(normals), _s(scratch), _flat(kFlat / axisStep)
    {
    }

    void run(const CellFrame& frame)
    {
        setUp(frame);
        for (int round = 0; round < kRounds; ++round) {
            std::size_t flips = 0;
            _s.changedBefore = _s.changed;
            std::ranges::fill(_s.changed, std::uint8_t{0});
            for (std::uint32_t corner = 0; corner < _mesh.indices.size(); ++corner)
                flips += flipAt(corner) ? 1U : 0U;
            if (flips == 0)
                break;
        }
        _mesh.compact();
    }

private:
    void setUp(const CellFrame& frame)
    {
        const std::size_t count = _mesh.vertices.size();
        _s.position.resize(count);
        for (std::size_t i = 0; i < count; ++i)
            _s.position[i] = frame.local(_mesh.vertices[i].position) - CellFrame::kMiddle;
        _s.firstCorner.assign(count, kNone);
        _s.nextCorner.resize(_mesh.indices.size());
        for (std::uint32_t corner = 0; corner < _mesh.indices.size(); ++corner)
            link(corner);
        _s.changed.assign(_mesh.indices.size() / 3, 1);
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

    /// The corner of `from` in the triangle in which `to` comes after it.
    [[nodiscard]] std::uint32_t cornerOf(std::uint16_t from, std::uint16_t to) const
    {
        std::uint32_t corner = _s.firstCorner[from];
        while (corner != kNone && _mesh.indices[next(corner)] != to)
            corner = _s.nextCorner[corner];
        return corner;
    }

    /// Flips the edge from a corner's vertex to the next if that is allowed and pays.
    bool flipAt(std::uint32_t corner)
    {
        const std::uint32_t second = next(corner);
        const std::uint16_t a = _mesh.indices[corner];
        const std::uint16_t b = _mesh.indices[second];
        if (a > b)
            return false; // the other triangle's turn
        const std::uint32_t across = cornerOf(b, a);
        if (across == kNone)
            return false; // on the border of the cell
        const std::uint32_t one = corner / 3;
        const std::uint32_t two = across / 3;
        if (_s.changedBefore[one] == 0 && _s.changedBefore[two] == 0 && _s.changed[one] == 0 &&
            _s.changed[two] == 0)
            return false; // nothing has changed since it was looked at
        const std::uint16_t c = _mesh.indices[next(second)];
        const std::uint16_t d = _mesh.indices[next(next(across))];
        const auto& vertices = _mesh.vertices;
        if ((vertices[c].feature & vertices[d].feature) != 0 || vertices[a].cap ||
            vertices[b].cap || vertices[c].cap || vertices[d].cap)
            return false;
        if (!(error(a, d, c) + error(d, b, c) < kGain * (error(a, b, c) + error(b, a, d))))
            return false;
        const TriangleShape abc = shape(a, b, c);
        const TriangleShape bad = shape(b, a, d);
        const TriangleShape adc = shape(a, d, c);
        const TriangleShape dbc = shape(d, b, c);
        if (!adc.facesLike(abc) || !adc.facesLike(bad) || !dbc.facesLike(abc) ||
            !dbc.facesLike(bad))
            return false;
        const double worst = std::min(adc.squaredQuality(), dbc.squaredQuality());
        if ((!adc.isAtLeast(kLeastShape) || !dbc.isAtLeast(kLeastShape)) &&
            worst < std::min(abc.squaredQuality(), bad.squaredQuality()))
            return false;
        if (cornerOf(c, d) != kNone || cornerOf(d, c) != kNone)
            return false;

        unlink(second);
        _mesh.indices[second] = d;
        link(second);
        const std::uint32_t other = next(across); // that of a in the second triangle
        unlink(other);
        _mesh.indices[other] = c;
        link(other);
        _s.changed[one] = 1;
        _s.changed[two] = 1;
        return true;
    }

    [[nodiscard]] TriangleShape shape(std::uint16_t a, std::uint16_t b, std::uint16_t c) const
    {
        return {_s.position[a], _s.position[b], _s.position[c]};
    }

    /// The integral over a triangle of the squared distance of the quadratic surface through its
    /// corners, times 720.
    [[nodiscard]] double error(std::uint16_t a, std::uint16_t b, std::uint16_t c) const
    {
        const std::array<std::uint16_t, 3> v{a, b, c};
        double squares = 0;
        double sum = 0;
        double flatSquares = 0;
        double flatSum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint16_t from = v[k];
            const std::uint16_t to = v[(k + 1) % 3];
            const glm::dvec3 side = _s.position[to] - _s.position[from];
            const double bend = glm::dot(_normals[to] - _normals[from], side);
            const double flat = _flat * glm::dot(side, side);
            squares += bend * bend;
            sum += bend;
            flatSquares += flat * flat;
            flatSum += flat;
        }
        const double area = 0.5 * std::sqrt(shape(a, b, c).squaredNormal);
        return area * (squares + sum * sum + flatSquares + flatSum * flatSum);
    }

    RoughMesh& _mesh;
    const std::vector<glm::dvec3>& _normals;
    AlignmentScratch& _s;
    double _flat; ///< [1 / cell unit]
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
