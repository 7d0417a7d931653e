#include "ExchangeFixture.h"

#include <glm/geometric.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>
#include <random>

namespace isofront::exchange::test {

ExchangeTest::ExchangeTest()
{
    const testing::TestInfo& test = *testing::UnitTest::GetInstance()->current_test_info();
    _folder = std::filesystem::temp_directory_path() /
              ("isofront-" + std::string(test.test_suite_name()) + "-" + test.name() + "-" +
               std::to_string(::getpid()));
    std::filesystem::remove_all(_folder);
    std::filesystem::create_directories(_folder);
}

ExchangeTest::~ExchangeTest()
{
    for (const std::string& name : names())
        EXPECT_FALSE(name.ends_with(".part")) << name << " was left behind";
    std::error_code ignored;
    std::filesystem::remove_all(_folder, ignored);
}

std::vector<std::string> ExchangeTest::names() const
{
    std::vector<std::string> result;
    for (const auto& entry : std::filesystem::directory_iterator(_folder))
        result.push_back(entry.path().filename().string());
    std::sort(result.begin(), result.end());
    return result;
}

std::string contentOf(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void setContent(const std::filesystem::path& path, const std::string& content)
{
    std::ofstream(path, std::ios::binary) << content;
}

surface::TriangleMesh ball(const glm::dvec3& centre, double radius, unsigned rings)
{
    surface::TriangleMesh mesh;
    const unsigned segments = 2 * rings;
    const auto add = [&](double latitude, double longitude) {
        const glm::dvec3 normal(
            std::cos(latitude) * std::cos(longitude),
            std::cos(latitude) * std::sin(longitude),
            std::sin(latitude));
        mesh.positions.push_back(centre + radius * normal);
        mesh.normals.emplace_back(normal);
        mesh.bounds.include(mesh.positions.back());
        return static_cast<std::uint32_t>(mesh.positions.size() - 1);
    };
    const std::uint32_t south = add(-std::numbers::pi / 2, 0);
    for (unsigned ring = 1; ring < rings; ++ring)
        for (unsigned segment = 0; segment < segments; ++segment)
            add(std::numbers::pi * (double(ring) / rings - 0.5),
                2 * std::numbers::pi * segment / segments);
    const std::uint32_t north = add(std::numbers::pi / 2, 0);
    const auto at = [&](unsigned ring, unsigned segment) {
        return ring == 0       ? south
               : ring == rings ? north
                               : 1 + (ring - 1) * segments + segment % segments;
    };
    const auto addTriangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (a != b && b != c && c != a)
            mesh.indices.insert(mesh.indices.end(), {a, b, c});
    };
    for (unsigned ring = 0; ring < rings; ++ring)
        for (unsigned segment = 0; segment < segments; ++segment) {
            addTriangle(at(ring, segment), at(ring, segment + 1), at(ring + 1, segment + 1));
            addTriangle(at(ring, segment), at(ring + 1, segment + 1), at(ring + 1, segment));
        }
    return mesh;
}

surface::TriangleMesh oneTriangle()
{
    surface::TriangleMesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    mesh.normals.assign(3, {0, 0, 1});
    mesh.indices = {0, 1, 2};
    for (const glm::dvec3& position : mesh.positions)
        mesh.bounds.include(position);
    return mesh;
}

surface::TriangleMesh randomMesh(
    unsigned seed,
    std::size_t vertices,
    std::size_t triangles,
    const glm::dvec3& centre,
    double size)
{
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> offset(-size / 2, size / 2);
    std::normal_distribution<double> direction;
    std::uniform_int_distribution<std::uint32_t> index(0, static_cast<std::uint32_t>(vertices - 1));
    surface::TriangleMesh mesh;
    for (std::size_t i = 0; i < vertices; ++i) {
        mesh.positions.push_back(
            centre + glm::dvec3(offset(random), offset(random), offset(random)));
        mesh.normals.emplace_back(
            glm::normalize(glm::dvec3(direction(random), direction(random), direction(random))));
        mesh.bounds.include(mesh.positions.back());
    }
    for (std::size_t i = 0; i < 3 * triangles; ++i)
        mesh.indices.push_back(index(random));
    return mesh;
}

} // namespace isofront::exchange::test
