#include "isofront/bench/TetrahedraContour.h"

#include "isofront/bench/GridContour.h"

#include <isofront/hierarchy/Tetrahedron.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

using hierarchy::LatticePoint;
using hierarchy::Tetrahedron;

/// The tetrahedra of one level that may hold a surface, by the numbers of their corners.
class Leaves {
public:
    Leaves(const fields::Field& field, double isovalue, const hierarchy::Domain& domain, int level)
        : _field(field), _isovalue(isovalue), _domain(domain), _level(level)
    {
        for (const Tetrahedron& root : hierarchy::rootTetrahedra())
            visit(root);
    }

    std::vector<std::array<std::uint32_t, 4>> tetrahedra;
    std::vector<LatticePoint> corners;
    std::size_t nodes = 0;

private:
    void visit(const Tetrahedron& tetrahedron)
    {
        ++nodes;
        // Every third level, because boxes shrink that slowly, and not the last ones: bounds cost
        // more there than the samples that they save.
        constexpr int kUnbounded = 9;
        if (tetrahedron.level % 3 == 0 && tetrahedron.level <= _level - kUnbounded) {
            const core::Box box{
                _domain.fieldFromLattice(tetrahedron.low()),
                _domain.fieldFromLattice(tetrahedron.high())};
            if (!_field.bounds(box, {0, 0}).contains(_isovalue))
                return;
        }
        if (tetrahedron.level < _level) {
            for (const Tetrahedron& half : tetrahedron.bisected())
                visit(half);
            return;
        }
        std::array<std::uint32_t, 4>& named = tetrahedra.emplace_back();
        for (std::size_t i = 0; i < 4; ++i) {
            const auto [found, isNew] = _numbers.try_emplace(
                tetrahedron.corner[i], static_cast<std::uint32_t>(corners.size()));
            if (isNew)
                corners.push_back(tetrahedron.corner[i]);
            named[i] = found->second;
        }
    }

    const fields::Field& _field;
    double _isovalue;
    const hierarchy::Domain& _domain;
    int _level;
    std::unordered_map<LatticePoint, std::uint32_t, hierarchy::LatticePointHash> _numbers;
};

} // namespace

TetrahedraMesh marchingTetrahedra(
    const fields::Field& field, double isovalue, const hierarchy::Domain& domain, int level)
{
    const Leaves leaves(field, isovalue, domain, level);
    const std::size_t count = leaves.corners.size();
    std::vector<double> x(count), y(count), z(count);
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) {
        const glm::dvec3 p = domain.fieldFromLattice(leaves.corners[i]);
        x[i] = p.x;
        y[i] = p.y;
        z[i] = p.z;
    }
    field.sample({x, y, z}, values);

    TetrahedraMesh result;
    result.tetrahedra = leaves.tetrahedra.size();
    result.samples = count;
    result.hierarchyNodes = leaves.nodes;
    surface::TriangleMesh& mesh = result.mesh;
    std::unordered_map<std::uint64_t, std::uint32_t> vertexOn;
    const auto positionOf = [&](std::uint32_t corner) {
        return glm::dvec3(x[corner], y[corner], z[corner]);
    };
    const auto vertexBetween = [&](std::uint32_t inside, std::uint32_t outside) {
        const std::uint64_t key =
            (std::uint64_t{std::min(inside, outside)} << 32U) | std::max(inside, outside);
        const auto [found, isNew] =
            vertexOn.try_emplace(key, static_cast<std::uint32_t>(mesh.positions.size()));
        if (isNew) {
            const double a = double(values[inside]) - isovalue;
            const double b = double(values[outside]) - isovalue;
            const glm::dvec3 p = positionOf(inside);
            mesh.positions.push_back(p + a / (a - b) * (positionOf(outside) - p));
        }
        return found->second;
    };
    for (const auto& corners : leaves.tetrahedra) {
        std::array<std::uint32_t, 4> ordered{}; // those inside first
        std::size_t inside = 0;
        std::size_t outside = 4;
        glm::dvec3 outward(0.0);
        for (const std::uint32_t corner : corners)
            if (double(values[corner]) >= isovalue)
                ordered[inside++] = corner;
            else
                ordered[--outside] = corner;
        if (inside == 0 || inside == 4)
            continue;
        for (std::size_t i = 0; i < 4; ++i)
            outward += positionOf(ordered[i]) / (i < inside ? -static_cast<double>(inside)
                                                            : 4.0 - static_cast<double>(inside));
        std::vector<std::array<std::uint32_t, 3>> triangles;
        if (inside == 2) {
            const std::uint32_t a = vertexBetween(ordered[0], ordered[2]);
            const std::uint32_t b = vertexBetween(ordered[0], ordered[3]);
            const std::uint32_t c = vertexBetween(ordered[1], ordered[3]);
            const std::uint32_t d = vertexBetween(ordered[1], ordered[2]);
            triangles = {{a, b, c}, {a, c, d}};
        } else if (inside == 1) {
            triangles = {
                {vertexBetween(ordered[0], ordered[1]),
                 vertexBetween(ordered[0], ordered[2]),
                 vertexBetween(ordered[0], ordered[3])}};
        } else {
            triangles = {
                {vertexBetween(ordered[0], ordered[3]),
                 vertexBetween(ordered[1], ordered[3]),
                 vertexBetween(ordered[2], ordered[3])}};
        }
        // all of them lie in one plane, which parts the inside from the outside
        glm::dvec3 normal(0.0);
        for (const auto& t : triangles)
            normal += glm::cross(
                mesh.positions[t[1]] - mesh.positions[t[0]],
                mesh.positions[t[2]] - mesh.positions[t[0]]);
        const bool isTurned = glm::dot(normal, outward) < 0;
        for (const auto& t : triangles)
            mesh.indices.insert(
                mesh.indices.end(), {t[0], t[isTurned ? 2 : 1], t[isTurned ? 1 : 2]});
    }
    for (glm::dvec3& position : mesh.positions) {
        position = domain.worldFromField.point(position);
        mesh.bounds.include(position);
    }
    if (domain.worldFromField.mirrors())
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            std::swap(mesh.indices[i + 1], mesh.indices[i + 2]);
    setNormals(mesh, field, domain);
    return result;
}

} // namespace isofront::bench
