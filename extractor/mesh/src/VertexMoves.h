#pragma once

#include "CellFrame.h"
#include "RoughMesh.h"

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// Where the vertices inside a cell are to go, and the rules of going there. Part of the worker's
/// scratch.
class VertexMoves {
public:
    /// Begins with every vertex where it is.
    void begin(const RoughMesh& mesh, const CellFrame& frame);

    /// Whether a vertex may move: neither a border vertex nor one of a cap.
    [[nodiscard]] bool isFree(std::size_t vertex) const { return _free[vertex] != 0; }
    /// Where a vertex is to go [cell units]. Of one that isn't free: where it is.
    [[nodiscard]] const glm::dvec3& operator[](std::size_t vertex) const { return _to[vertex]; }
    [[nodiscard]] glm::dvec3& operator[](std::size_t vertex) { return _to[vertex]; }
    [[nodiscard]] std::size_t size() const { return _to.size(); }

    /// Moves the free vertices, snapped to the cell unit. A vertex that would leave the cell's box,
    /// or turn one of its triangles by more than 78 degrees or make a sliver of it, stays, and so
    /// do the other vertices of that triangle.
    void commit(RoughMesh& mesh, const CellFrame& frame);

private:
    std::vector<glm::dvec3> _from;
    std::vector<glm::dvec3> _to;
    std::vector<std::uint8_t> _free;
};

} // namespace isofront::extractor
