#include "VertexMoves.h"

#include "TriangleShape.h"

#include <cmath>

namespace isofront::extractor {

void VertexMoves::begin(const RoughMesh& mesh, const CellFrame& frame)
{
    const std::size_t count = mesh.vertices.size();
    _from.resize(count);
    _free.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        _from[i] = frame.local(mesh.vertices[i].position);
        _free[i] = mesh.vertices[i].isLocked() ? 0 : 1;
    }
    _to = _from;
}

void VertexMoves::commit(RoughMesh& mesh, const CellFrame& frame)
{
    for (std::size_t i = 0; i < _to.size(); ++i) {
        const glm::dvec3 snapped(std::round(_to[i].x), std::round(_to[i].y), std::round(_to[i].z));
        bool inBox = true; // false for NaN
        for (std::size_t axis = 0; axis < 3; ++axis)
            inBox = inBox && snapped[axis] >= 0 && snapped[axis] <= double(CellFrame::kSize);
        _to[i] = _free[i] != 0 && inBox ? snapped : _from[i];
    }

    // Taking a move back may spoil a triangle that was good, so look again until all are. Each
    // round takes a move back, and with none left all triangles are as they were.
    for (bool again = true; again;) {
        again = false;
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
            const std::uint16_t a = mesh.indices[i];
            const std::uint16_t b = mesh.indices[i + 1];
            const std::uint16_t c = mesh.indices[i + 2];
            if (_to[a] == _from[a] && _to[b] == _from[b] && _to[c] == _from[c])
                continue;
            const TriangleShape before(_from[a], _from[b], _from[c]);
            const TriangleShape after(_to[a], _to[b], _to[c]);
            if (after.facesLike(before) &&
                (after.isAtLeast(kLeastShape) || !after.isWorseThan(before)))
                continue;
            _to[a] = _from[a];
            _to[b] = _from[b];
            _to[c] = _from[c];
            again = true;
        }
    }

    for (std::size_t i = 0; i < _to.size(); ++i)
        if (_to[i] != _from[i])
            mesh.vertices[i].position = frame.grid(glm::i64vec3(_to[i]));
}

} // namespace isofront::extractor
