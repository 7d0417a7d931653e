// Based on: Turk, "The PLY Polygon File Format", 1994.

#include "BlockWriter.h"
#include "MeshFormats.h"

#include <limits>
#include <string>

namespace isofront::exchange {

core::Result<void> writePly(const MeshJob& job)
{
    const MeshView& mesh = job.mesh;
    if (mesh.vertexCount() > std::size_t{std::numeric_limits<std::int32_t>::max()})
        return core::failure(
            core::ErrorCode::resourceLimit,
            "PLY names at most 2^31 vertices, and the mesh has " +
                std::to_string(mesh.vertexCount()) + "; write .stl, or extract less detail");

    std::string head =
        "ply\nformat binary_little_endian 1.0\ncomment " + inOneLine(job.options.generator) + "\n";
    for (const auto& [key, value] : job.options.settings)
        head += "comment " + inOneLine(key) + " " + inOneLine(value) + "\n";
    head += "element vertex " + std::to_string(mesh.vertexCount()) +
            "\nproperty double x\nproperty double y\nproperty double z\n";
    if (mesh.hasNormals())
        head += "property float nx\nproperty float ny\nproperty float nz\n";
    if (mesh.hasAttributes())
        head += "property uint attribute\n";
    head += "element face " + std::to_string(mesh.triangleCount()) +
            "\nproperty list uchar int vertex_indices\nend_header\n";

    BlockWriter out(job.file);
    out.put(std::string_view(head));
    for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
        out.put(mesh.position(vertex));
        if (mesh.hasNormals())
            out.put(mesh.normal(vertex));
        if (mesh.hasAttributes())
            out.put(mesh.attribute(vertex));
    }
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        out.put(std::uint8_t{3});
        for (int corner = 0; corner < 3; ++corner)
            out.put(mesh.triangle(triangle)[corner]);
    }
    return {};
}

} // namespace isofront::exchange
