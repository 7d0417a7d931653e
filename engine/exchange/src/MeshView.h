#pragma once

#include "isofront/exchange/MeshFile.h"

#include <isofront/core/Box.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>

namespace isofront::exchange {

/// A mesh that was found fit for export. Refers to the mesh that it was made from.
class MeshView {
public:
    /// Fails with `badData` if the mesh contradicts itself or has coordinates that are not finite.
    static core::Result<MeshView> of(const surface::TriangleMesh& mesh);

    /// Without triangles; then there are no vertices to export either.
    [[nodiscard]] bool isEmpty() const { return _mesh->indices.empty(); }
    [[nodiscard]] bool hasNormals() const { return !isEmpty() && !_mesh->normals.empty(); }
    [[nodiscard]] bool hasAttributes() const { return !isEmpty() && !_mesh->attributes.empty(); }
    [[nodiscard]] std::size_t vertexCount() const
    {
        return isEmpty() ? 0 : _mesh->positions.size();
    }
    [[nodiscard]] std::size_t triangleCount() const { return _mesh->indices.size() / 3; }

    [[nodiscard]] const glm::dvec3& position(std::size_t vertex) const
    {
        return _mesh->positions[vertex];
    }
    /// Of unit length; the z axis where the mesh has none that can be made so.
    [[nodiscard]] glm::vec3 normal(std::size_t vertex) const;
    [[nodiscard]] std::uint32_t attribute(std::size_t vertex) const
    {
        return _mesh->attributes[vertex];
    }
    [[nodiscard]] const std::uint32_t* triangle(std::size_t index) const
    {
        return _mesh->indices.data() + 3 * index;
    }
    /// Of all positions, measured here [world]; empty if the mesh is.
    [[nodiscard]] const core::Box& bounds() const { return _bounds; }
    /// How many normals point nowhere.
    [[nodiscard]] std::size_t unusableNormals() const { return _unusableNormals; }

private:
    explicit MeshView(const surface::TriangleMesh& mesh) : _mesh(&mesh) {}

    const surface::TriangleMesh* _mesh;
    core::Box _bounds;
    std::size_t _unusableNormals = 0;
};

} // namespace isofront::exchange
