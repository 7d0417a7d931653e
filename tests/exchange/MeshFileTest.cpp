#include "ExchangeFixture.h"
#include "MeshReaders.h"

#include <isofront/exchange/MeshFile.h>

#include <glm/geometric.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <limits>

namespace isofront::exchange::test {

namespace {

class MeshFileTest : public ExchangeTest {};

constexpr const char* kExtensions[] = {".glb", ".ply", ".obj", ".stl"};

ReadMesh readMesh(const std::filesystem::path& path)
{
    const std::string extension = path.extension().string();
    return extension == ".glb"   ? readGlb(path)
           : extension == ".ply" ? readPly(path)
           : extension == ".obj" ? readObj(path)
                                 : readStl(path);
}

/// Meshes at the edges of what a mesh can be, with names.
std::vector<std::pair<std::string, surface::TriangleMesh>> meshes()
{
    return {
        {"one triangle", oneTriangle()},
        {"ball", ball({1.0 / 3, -2, 1e-3}, 10, 24)},
        {"ball 6400 km out", ball({6.4e6 + 0.001, -6.4e6, 3.0}, 25, 12)},
        {"soup", randomMesh(1, 100, 300, {0, 0, 0}, 1)},
        {"soup far out", randomMesh(2, 500, 200, {-1e9, 1e9, 0.1}, 1e3)},
        {"soup of tiny triangles", randomMesh(3, 100, 99, {1e-6, 0, 0}, 1e-9)},
        {"most vertices of 16 bits", randomMesh(4, 65535, 21845, {5, 6, 7}, 100)},
        {"one vertex more", randomMesh(5, 65536, 21845, {5, 6, 7}, 100)},
    };
}

void expectSameTopology(const surface::TriangleMesh& mesh, const ReadMesh& read)
{
    EXPECT_EQ(read.indices, mesh.indices);
    EXPECT_EQ(read.normals, mesh.normals);
    ASSERT_EQ(read.positions.size(), mesh.positions.size());
}

} // namespace

TEST_F(MeshFileTest, knowsFormatsByTheirExtensionInAnyCase)
{
    EXPECT_EQ(meshFormatOf("a/b.glb"), MeshFormat::glb);
    EXPECT_EQ(meshFormatOf("b.PLY"), MeshFormat::ply);
    EXPECT_EQ(meshFormatOf("b.tar.Obj"), MeshFormat::obj);
    EXPECT_EQ(meshFormatOf("b.stl"), MeshFormat::stl);
}

TEST_F(MeshFileTest, namesTheFormatsWhenAskedForAnother)
{
    for (const char* name : {"mesh.fbx", "mesh", ".glb", "mesh.", "mesh.glb.gz", ""}) {
        const auto report = writeMesh(oneTriangle(), path("x").parent_path() / name);
        ASSERT_FALSE(report) << name;
        EXPECT_EQ(report.error().code, core::ErrorCode::usage);
        EXPECT_NE(report.error().message.find(".glb, .ply, .obj or .stl"), std::string::npos);
    }
    EXPECT_TRUE(names().empty());
}

TEST_F(MeshFileTest, keepsEveryBitInPlyAndObj)
{
    for (const auto& [name, mesh] : meshes())
        for (const char* extension : {".ply", ".obj"}) {
            SCOPED_TRACE(name + " as " + extension);
            const auto report = writeMesh(mesh, path("mesh").concat(extension));
            ASSERT_TRUE(report) << report.error().message;
            EXPECT_EQ(report->bytes, std::filesystem::file_size(path("mesh").concat(extension)));
            EXPECT_EQ(report->positionError, 0);
            EXPECT_TRUE(report->warnings.empty());
            const ReadMesh read = readMesh(path("mesh").concat(extension));
            expectSameTopology(mesh, read);
            EXPECT_EQ(read.positions, mesh.positions);
        }
}

TEST_F(MeshFileTest, writesGlbThatTinygltfReadsAsTheSameMesh)
{
    for (const auto& [name, mesh] : meshes()) {
        SCOPED_TRACE(name);
        const auto report = writeMesh(mesh, path("mesh.glb"));
        ASSERT_TRUE(report) << report.error().message;
        EXPECT_EQ(report->bytes, std::filesystem::file_size(path("mesh.glb")));
        const ReadMesh read = readGlb(path("mesh.glb"));
        expectSameTopology(mesh, read);
        double error = 0;
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const glm::dvec3 off = glm::abs(read.positions[i] - mesh.positions[i]);
            error = std::max({error, off.x, off.y, off.z});
        }
        EXPECT_EQ(report->positionError, error) << "the report tells the true error";
        // Half a unit in the last place of local coordinates; the rest is the double's own.
        const glm::dvec3 size = mesh.bounds.size();
        const glm::dvec3 far = glm::max(glm::abs(mesh.bounds.low), glm::abs(mesh.bounds.high));
        const double extent = std::max({size.x, size.y, size.z});
        const double furthest = std::max({far.x, far.y, far.z});
        EXPECT_LE(error, std::ldexp(extent, -24) + std::ldexp(furthest, -46));
    }
}

TEST_F(MeshFileTest, losesAtMostMicrometresInGlbAtTheEarthsRadius)
{
    const auto report = writeMesh(ball({6.4e6 + 0.001, 0, 0}, 25, 12), path("mesh.glb"));
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_LT(report->positionError, 2e-6);
    const auto stl = writeMesh(ball({6.4e6 + 0.001, 0, 0}, 25, 12), path("mesh.stl"));
    ASSERT_TRUE(stl) << stl.error().message;
    EXPECT_GT(stl->positionError, 0.1) << "where plain floats lose decimetres";
}

TEST_F(MeshFileTest, writesStlRoundedToFloatAndSaysSo)
{
    for (const auto& [name, mesh] : meshes()) {
        SCOPED_TRACE(name);
        const auto report = writeMesh(mesh, path("mesh.stl"));
        ASSERT_TRUE(report) << report.error().message;
        EXPECT_EQ(report->bytes, 84 + 50 * mesh.indices.size() / 3);
        const ReadMesh read = readStl(path("mesh.stl"));
        EXPECT_FALSE(read.comments.at(0).starts_with("solid"));
        ASSERT_EQ(read.positions.size(), mesh.indices.size());
        double error = 0;
        for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
            const glm::dvec3& exact = mesh.positions[mesh.indices[i]];
            EXPECT_EQ(read.positions[i], glm::dvec3(glm::vec3(exact)));
            const glm::dvec3 off = glm::abs(read.positions[i] - exact);
            error = std::max({error, off.x, off.y, off.z});
        }
        EXPECT_EQ(report->positionError, error);
        EXPECT_EQ(report->warnings.empty(), error == 0);
    }
}

TEST_F(MeshFileTest, pointsStlNormalsOutOfABall)
{
    const glm::dvec3 centre(6.4e6 + 0.001, 0, 0);
    ASSERT_TRUE(writeMesh(ball(centre, 25, 12), path("mesh.stl")));
    const ReadMesh read = readStl(path("mesh.stl"));
    ASSERT_FALSE(read.normals.empty());
    for (std::size_t i = 0; i < read.normals.size(); ++i) {
        const glm::dvec3 middle =
            (read.positions[3 * i] + read.positions[3 * i + 1] + read.positions[3 * i + 2]) / 3.0;
        EXPECT_GT(glm::dot(glm::dvec3(read.normals[i]), glm::normalize(middle - centre)), 0.9);
        EXPECT_NEAR(glm::length(glm::dvec3(read.normals[i])), 1, 1e-6);
    }
}

TEST_F(MeshFileTest, writesNoNormalsWhereTheMeshHasNone)
{
    surface::TriangleMesh mesh = ball({0, 0, 0}, 1, 8);
    mesh.normals.clear();
    for (const char* extension : {".glb", ".ply", ".obj"}) {
        ASSERT_TRUE(writeMesh(mesh, path("mesh").concat(extension)));
        const ReadMesh read = readMesh(path("mesh").concat(extension));
        EXPECT_TRUE(read.normals.empty());
        EXPECT_EQ(read.indices, mesh.indices);
    }
}

TEST_F(MeshFileTest, makesNormalsUnitAndCountsThoseWithoutDirection)
{
    surface::TriangleMesh mesh = oneTriangle();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    mesh.normals = {{0, 3, 4}, {0, 0, 0}, {kNan, 0, 0}};
    for (const char* extension : {".glb", ".ply", ".obj"}) {
        const auto report = writeMesh(mesh, path("mesh").concat(extension));
        ASSERT_TRUE(report) << report.error().message;
        ASSERT_EQ(report->warnings.size(), 1U);
        EXPECT_TRUE(report->warnings[0].starts_with("2 normals")) << report->warnings[0];
        EXPECT_EQ(
            readMesh(path("mesh").concat(extension)).normals,
            (core::LargeVector<glm::vec3>{{0, 0.6F, 0.8F}, {0, 0, 1}, {0, 0, 1}}));
    }
}

TEST_F(MeshFileTest, writesAValidFileWithoutTrianglesForAnEmptySurface)
{
    surface::TriangleMesh verticesOnly = oneTriangle();
    verticesOnly.indices.clear();
    for (const auto& mesh : {surface::TriangleMesh{}, verticesOnly})
        for (const char* extension : kExtensions) {
            SCOPED_TRACE(extension);
            const auto report = writeMesh(mesh, path("mesh").concat(extension));
            ASSERT_TRUE(report) << report.error().message;
            ASSERT_EQ(report->warnings.size(), 1U);
            EXPECT_NE(report->warnings[0].find("empty"), std::string::npos);
            const ReadMesh read = readMesh(path("mesh").concat(extension));
            EXPECT_TRUE(read.positions.empty());
            EXPECT_TRUE(read.indices.empty());
        }
}

TEST_F(MeshFileTest, keepsSettingsOnOneLineWhateverTheyHold)
{
    ExportOptions options;
    options.generator = "Isofront 1.2\nend_header";
    options.settings = {{"isovalue", "0.5"}, {"note", "line\r\nv 1 2 3\n\"quoted\" \xff"}};
    const surface::TriangleMesh mesh = oneTriangle();
    for (const char* extension : {".ply", ".obj"}) {
        ASSERT_TRUE(writeMesh(mesh, path("mesh").concat(extension), options));
        const ReadMesh read = readMesh(path("mesh").concat(extension));
        EXPECT_EQ(read.positions, mesh.positions);
        ASSERT_EQ(read.comments.size(), 3U);
        EXPECT_EQ(read.comments[0], "Isofront 1.2 end_header");
        EXPECT_EQ(read.comments[1], "isovalue 0.5");
    }
    ASSERT_TRUE(writeMesh(mesh, path("mesh.glb"), options));
    EXPECT_EQ(readGlb(path("mesh.glb")).comments.at(0), options.generator);
    EXPECT_NE(contentOf(path("mesh.glb")).find("\"isovalue\":\"0.5\""), std::string::npos);
}

TEST_F(MeshFileTest, givesTheSameBytesEachTime)
{
    for (const char* extension : kExtensions) {
        ASSERT_TRUE(writeMesh(ball({1, 2, 3}, 4, 16), path("a").concat(extension)));
        ASSERT_TRUE(writeMesh(ball({1, 2, 3}, 4, 16), path("b").concat(extension)));
        EXPECT_EQ(contentOf(path("a").concat(extension)), contentOf(path("b").concat(extension)));
    }
}

TEST_F(MeshFileTest, keepsAttributesWholeWhereTheFormatHasAPlaceForThem)
{
    for (const bool normals : {true, false}) {
        surface::TriangleMesh mesh = ball({1, 2, 3}, 4, 16);
        if (!normals)
            mesh.normals.clear();
        for (std::size_t i = 0; i < mesh.positions.size(); ++i)
            mesh.attributes.push_back(static_cast<std::uint32_t>(0xf0e1d2c3U * (i + 1)));
        for (const char* extension : kExtensions) {
            const auto report = writeMesh(mesh, path("mesh").concat(extension));
            ASSERT_TRUE(report) << report.error().message;
            const ReadMesh read = readMesh(path("mesh").concat(extension));
            const bool hasPlace =
                std::string(extension) == ".glb" || std::string(extension) == ".ply";
            if (hasPlace) {
                EXPECT_EQ(read.attributes, mesh.attributes) << extension;
                EXPECT_EQ(read.indices, mesh.indices) << extension;
                EXPECT_EQ(read.normals, mesh.normals) << extension;
            } else {
                ASSERT_FALSE(report->warnings.empty());
                EXPECT_NE(report->warnings.front().find("attributes"), std::string::npos);
            }
        }
    }
}

TEST_F(MeshFileTest, refusesMeshesThatContradictThemselves)
{
    std::vector<std::pair<std::string, surface::TriangleMesh>> broken;
    broken.emplace_back("past its 3 positions", oneTriangle()).second.indices[1] = 3;
    broken.emplace_back("not three a triangle", oneTriangle()).second.indices.push_back(0);
    broken.emplace_back("2 normals for 3", oneTriangle()).second.normals.pop_back();
    broken.emplace_back("1 attributes for 3", oneTriangle()).second.attributes = {7};
    broken.emplace_back("position 2 is not a finite", oneTriangle()).second.positions[2].y =
        std::numeric_limits<double>::infinity();
    broken.emplace_back("position 0 is not a finite", oneTriangle()).second.positions[0].z =
        std::numeric_limits<double>::quiet_NaN();
    for (const auto& [why, mesh] : broken)
        for (const char* extension : kExtensions) {
            const auto report = writeMesh(mesh, path("mesh").concat(extension));
            ASSERT_FALSE(report) << why;
            EXPECT_EQ(report.error().code, core::ErrorCode::badData);
            EXPECT_NE(report.error().message.find(why), std::string::npos)
                << report.error().message;
        }
    EXPECT_TRUE(names().empty());
}

TEST_F(MeshFileTest, refusesCoordinatesPastFloatOnlyWhereFloatsAreStored)
{
    surface::TriangleMesh mesh = oneTriangle();
    mesh.positions[1].x = 1e300;
    for (const char* extension : {".glb", ".stl"}) {
        const auto report = writeMesh(mesh, path("mesh").concat(extension));
        ASSERT_FALSE(report);
        EXPECT_EQ(report.error().code, core::ErrorCode::badData);
        EXPECT_NE(report.error().message.find("write .ply or .obj"), std::string::npos);
    }
    for (const char* extension : {".ply", ".obj"}) {
        ASSERT_TRUE(writeMesh(mesh, path("mesh").concat(extension)));
        EXPECT_EQ(readMesh(path("mesh").concat(extension)).positions, mesh.positions);
    }
}

TEST_F(MeshFileTest, keepsTheOldFileAndNoOtherWhenTheDiskIsFull)
{
    const surface::TriangleMesh mesh = ball({0, 0, 0}, 1, 200);
    // A limit on a file's size fails as a full disk does, in the middle of a write.
    rlimit old{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
    const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
    for (const char* extension : kExtensions) {
        SCOPED_TRACE(extension);
        setContent(path("mesh").concat(extension), "what was there");
        const rlimit tight{1'500'000, old.rlim_max};
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
        const auto report = writeMesh(mesh, path("mesh").concat(extension));
        ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
        ASSERT_FALSE(report);
        EXPECT_EQ(report.error().code, core::ErrorCode::inputOutput);
        EXPECT_EQ(contentOf(path("mesh").concat(extension)), "what was there");
        EXPECT_EQ(names().size(), 1U);
        std::filesystem::remove(path("mesh").concat(extension));
    }
    std::signal(SIGXFSZ, oldHandler);
}

TEST_F(MeshFileTest, tellsThatTheDeviceIsFull)
{
    for (const char* extension : kExtensions) {
        const auto link = path("full").concat(extension);
        std::filesystem::create_symlink("/dev/full", link);
        const auto report = writeMesh(ball({0, 0, 0}, 1, 8), link);
        ASSERT_FALSE(report);
        EXPECT_EQ(report.error().code, core::ErrorCode::inputOutput);
        EXPECT_NE(report.error().message.find("No space left on device"), std::string::npos);
        EXPECT_NE(report.error().message.find("free some space"), std::string::npos);
        EXPECT_TRUE(std::filesystem::is_symlink(link));
    }
}

} // namespace isofront::exchange::test
