#pragma once

#include <isofront/core/LargeVector.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace isofront::exchange::test {

/// A mesh as a file holds it. Readers that share nothing with the writers fill it; what they don't
/// expect is a test failure.
struct ReadMesh {
    core::LargeVector<glm::dvec3> positions;
    core::LargeVector<glm::vec3> normals;
    core::LargeVector<std::uint32_t> attributes;
    core::LargeVector<std::uint32_t> indices;
    std::vector<std::string> comments;
};

/// Through tinygltf; positions have the node's transform applied, in double.
ReadMesh readGlb(const std::filesystem::path& path);
/// Line by line after the header's own words: any order of properties of the types that it names.
ReadMesh readPly(const std::filesystem::path& path);
ReadMesh readObj(const std::filesystem::path& path);
/// Facet by facet: three positions and one normal a triangle.
ReadMesh readStl(const std::filesystem::path& path);

} // namespace isofront::exchange::test
