#include "ExchangeFixture.h"

#include <isofront/exchange/MeshFile.h>

#include <cstdio>

namespace isofront::exchange::test {

namespace {

class GltfValidatorTest : public ExchangeTest {};

/// Runs a command that has no untrusted part. @return its exit status and what it printed
std::pair<int, std::string> outputOf(const std::string& command)
{
    std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
    EXPECT_NE(pipe, nullptr);
    std::string text;
    char block[512];
    while (const std::size_t count = std::fread(block, 1, sizeof block, pipe))
        text.append(block, count);
    return {::pclose(pipe), text};
}

} // namespace

TEST_F(GltfValidatorTest, findsNoErrorAndNoWarningInAnyFile)
{
    const std::filesystem::path validator = ISOFRONT_VALIDATOR_DIR;
    ASSERT_TRUE(std::filesystem::exists(ISOFRONT_NODE)) << "install nodejs and configure again";
    ASSERT_TRUE(std::filesystem::exists(validator / "node_modules" / "gltf-validator"))
        << "install the validator: (cd " << validator << " && npm ci)";

    surface::TriangleMesh withoutNormals = ball({0, 0, 0}, 1, 8);
    withoutNormals.normals.clear();
    surface::TriangleMesh badNormals = oneTriangle();
    badNormals.normals = {{0, 3, 4}, {0, 0, 0}, {1e-30F, 0, 0}};
    surface::TriangleMesh coloured = ball({0, 0, 0}, 1, 8);
    coloured.attributes.assign(coloured.positions.size(), 0xff804020U);
    const std::pair<const char*, surface::TriangleMesh> cases[] = {
        {"empty", {}},
        {"triangle", oneTriangle()},
        {"ball", ball({1.0 / 3, -2, 1e-3}, 10, 24)},
        {"far", ball({6.4e6 + 0.001, -6.4e6, 3.0}, 25, 12)},
        {"soup", randomMesh(1, 1000, 3000, {-1e9, 0, 0}, 1e-3)},
        {"long", randomMesh(2, 65536, 21845, {5, 6, 7}, 100)},
        {"without-normals", withoutNormals},
        {"bad-normals", badNormals},
        {"coloured", coloured},
    };
    ExportOptions options;
    options.settings = {{"spacing", "0.5"}, {"name", "\"\\\xff\n"}};
    std::string command =
        std::string(ISOFRONT_NODE) + " '" + (validator / "validate.cjs").string() + "'";
    for (const auto& [name, mesh] : cases) {
        const std::filesystem::path file = path(name).concat(".glb");
        const auto report = writeMesh(mesh, file, options);
        ASSERT_TRUE(report) << report.error().message;
        command += " '" + file.string() + "'";
    }
    const auto [status, output] = outputOf(command);
    EXPECT_EQ(status, 0) << output;
    EXPECT_NE(output.find("long.glb: 0 errors, 0 warnings, 21845 triangles"), std::string::npos)
        << output;

    // The validator must be able to say no, or its yes means nothing.
    std::string broken = contentOf(path("ball.glb"));
    broken[broken.size() - 2] = '\x7f'; // an index past the vertices
    setContent(path("broken.glb"), broken);
    const auto [brokenStatus, brokenOutput] = outputOf(
        std::string(ISOFRONT_NODE) + " '" + (validator / "validate.cjs").string() + "' '" +
        path("broken.glb").string() + "'");
    EXPECT_NE(brokenStatus, 0) << brokenOutput;
}

} // namespace isofront::exchange::test
