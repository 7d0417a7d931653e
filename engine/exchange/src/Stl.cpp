// Based on: 3D Systems, "StereoLithography Interface Specification", 1988: the binary form.

#include "BlockWriter.h"
#include "MeshFormats.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace isofront::exchange {

namespace {

/// The unit normal of a triangle, zero if it has no area. From differences, so that it is right far
/// from the origin.
glm::vec3 facetNormal(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    const glm::dvec3 normal = glm::cross(b - a, c - a);
    const double length = glm::length(normal);
    return std::isfinite(length) && length > 0 ? glm::vec3(normal / length) : glm::vec3(0);
}

std::string scientific(double value)
{
    char text[32];
    (void)std::snprintf(text, sizeof text, "%.2g", value);
    return text;
}

} // namespace

core::Result<void> writeStl(const MeshJob& job)
{
    const MeshView& mesh = job.mesh;
    if (mesh.triangleCount() > std::size_t{std::numeric_limits<std::uint32_t>::max()})
        return core::failure(
            core::ErrorCode::resourceLimit,
            "STL counts at most 2^32 triangles, and the mesh has " +
                std::to_string(mesh.triangleCount()) + "; write .ply, or extract less detail");
    if (!mesh.isEmpty()) {
        const glm::dvec3 furthest =
            glm::max(glm::abs(mesh.bounds().low), glm::abs(mesh.bounds().high));
        if (std::max({furthest.x, furthest.y, furthest.z}) >
            static_cast<double>(std::numeric_limits<float>::max()))
            return core::failure(
                core::ErrorCode::badData,
                "its coordinates are too large for STL, which stores floats; write .ply or .obj");
    }

    BlockWriter out(job.file);
    std::array<char, 80> head{};
    // A reader takes a file that opens with "solid" for the text form.
    const std::string name = "binary STL, " + inOneLine(job.options.generator);
    std::copy_n(name.begin(), std::min(name.size(), head.size()), head.begin());
    out.put(head);
    out.put(static_cast<std::uint32_t>(mesh.triangleCount()));

    double error = 0;
    std::size_t collapsed = 0;
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        std::array<glm::dvec3, 3> exact;
        std::array<glm::vec3, 3> rounded;
        for (std::size_t corner = 0; corner < 3; ++corner) {
            exact[corner] = mesh.position(mesh.triangle(triangle)[corner]);
            rounded[corner] = glm::vec3(exact[corner]);
            const glm::dvec3 off = glm::abs(glm::dvec3(rounded[corner]) - exact[corner]);
            error = std::max({error, off.x, off.y, off.z});
        }
        out.put(facetNormal(exact[0], exact[1], exact[2]));
        for (const glm::vec3& corner : rounded)
            out.put(corner);
        out.put(std::uint16_t{0});
        const auto hasEqualCorners = [](const auto& c) {
            return c[0] == c[1] || c[1] == c[2] || c[2] == c[0];
        };
        if (hasEqualCorners(rounded) && !hasEqualCorners(exact))
            ++collapsed;
    }

    job.report.positionError = error;
    if (error > 0) {
        std::string warning = "STL stores floats: coordinates moved by up to " + scientific(error);
        if (collapsed > 0)
            warning += ", and " + std::to_string(collapsed) + " triangles collapsed";
        job.report.warnings.push_back(warning + "; write .ply to keep them exact");
    }
    return {};
}

} // namespace isofront::exchange
