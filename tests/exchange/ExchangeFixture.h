#pragma once

#include <isofront/surface/TriangleMesh.h>

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

namespace isofront::exchange::test {

/// Gives each test a folder of its own and checks at the end that no temporary file is left in it.
class ExchangeTest : public testing::Test {
protected:
    ExchangeTest();
    ~ExchangeTest() override;

    [[nodiscard]] std::filesystem::path path(const std::string& name) const
    {
        return _folder / name;
    }
    [[nodiscard]] const std::filesystem::path& folder() const { return _folder; }
    /// Names of all that is in the folder, hidden files included, sorted.
    [[nodiscard]] std::vector<std::string> names() const;

private:
    std::filesystem::path _folder;
};

std::string contentOf(const std::filesystem::path& path);
void setContent(const std::filesystem::path& path, const std::string& content);

/// A closed ball of `rings` x `2 rings` quads, with shared vertices and exact unit normals (up to
/// float). Positions use all bits of a double.
surface::TriangleMesh ball(const glm::dvec3& centre, double radius, unsigned rings);
/// One triangle with a vertex at the origin and normals along z.
surface::TriangleMesh oneTriangle();
/// Vertices and indices at random, from a fixed seed, around a centre [world].
surface::TriangleMesh randomMesh(
    unsigned seed,
    std::size_t vertices,
    std::size_t triangles,
    const glm::dvec3& centre,
    double size);

} // namespace isofront::exchange::test
