#include "MeshView.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <string>

namespace isofront::exchange {

namespace {

/// A unit vector rounded to float is off by far less than this; the strictest reader that we know
/// (the Khronos glTF validator) allows 0.00674.
constexpr double kUnitTolerance = 1e-4;

bool isUsable(double length)
{
    return std::isfinite(length) && length > 0;
}

core::Error badMesh(const std::string& why)
{
    return {
        core::ErrorCode::badData,
        "can't export the mesh: " + why + "; it was not made by a healthy extraction"};
}

} // namespace

core::Result<MeshView> MeshView::of(const surface::TriangleMesh& mesh)
{
    MeshView view(mesh);
    if (mesh.indices.size() % 3 != 0)
        return tl::unexpected(badMesh(
            "its " + std::to_string(mesh.indices.size()) + " indices are not three a triangle"));
    if (view.isEmpty())
        return view;
    if (!mesh.normals.empty() && mesh.normals.size() != mesh.positions.size())
        return tl::unexpected(badMesh(
            "it has " + std::to_string(mesh.normals.size()) + " normals for " +
            std::to_string(mesh.positions.size()) + " positions"));
    if (!mesh.attributes.empty() && mesh.attributes.size() != mesh.positions.size())
        return tl::unexpected(badMesh(
            "it has " + std::to_string(mesh.attributes.size()) + " attributes for " +
            std::to_string(mesh.positions.size()) + " positions"));
    const std::uint32_t last = *std::max_element(mesh.indices.begin(), mesh.indices.end());
    if (last >= mesh.positions.size())
        return tl::unexpected(badMesh(
            "index " + std::to_string(last) + " is past its " +
            std::to_string(mesh.positions.size()) + " positions"));
    for (std::size_t vertex = 0; vertex < mesh.positions.size(); ++vertex) {
        const glm::dvec3& p = mesh.positions[vertex];
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
            return tl::unexpected(
                badMesh("position " + std::to_string(vertex) + " is not a finite number"));
        view._bounds.include(p);
    }
    view._unusableNormals = static_cast<std::size_t>(
        std::count_if(mesh.normals.begin(), mesh.normals.end(), [](const glm::vec3& normal) {
            return !isUsable(glm::length(glm::dvec3(normal)));
        }));
    return view;
}

glm::vec3 MeshView::normal(std::size_t vertex) const
{
    const glm::vec3& normal = _mesh->normals[vertex];
    const double length = glm::length(glm::dvec3(normal));
    if (!isUsable(length))
        return {0, 0, 1};
    if (std::abs(length - 1) <= kUnitTolerance)
        return normal;
    return glm::vec3(glm::dvec3(normal) / length);
}

} // namespace isofront::exchange
