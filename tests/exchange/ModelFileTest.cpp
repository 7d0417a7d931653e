// What readers of meshes make of good files, real ones and damaged ones.

#include "ExchangeFixture.h"
#include "models/ModelFormats.h"
#include "support/Random.h"

#include <isofront/exchange/MeshFile.h>
#include <isofront/exchange/ModelFile.h>

#include <glm/common.hpp>
#include <zlib.h>

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <string>
#include <vector>

namespace isofront::exchange::test {

namespace {

constexpr const char* kFormats[] = {".glb", ".ply", ".obj", ".stl"};

class ModelFileTest : public ExchangeTest {
protected:
    voxels::TriangleModel read(const std::string& name) const
    {
        auto model = readModel(path(name));
        EXPECT_TRUE(model) << model.error().message;
        return model ? std::move(*model) : voxels::TriangleModel();
    }
    /// A file of a ball of 24 triangles.
    std::string smallFile(const std::string& format) const
    {
        EXPECT_TRUE(writeMesh(ball({1, 2, 3}, 1, 3), path("small" + format)));
        return contentOf(path("small" + format));
    }
    /// Reads what a file would hold that is not as it should be: what comes back is an error in one
    /// line, or a model that is no larger than the file can make it.
    core::Result<voxels::TriangleModel>
    readBytes(const std::string& format, const std::string& content) const
    {
        const auto reader = format == ".glb"   ? readGltf
                            : format == ".ply" ? exchange::readPly
                            : format == ".obj" ? exchange::readObj
                                               : exchange::readStl;
        auto model = reader(std::as_bytes(std::span(content)), {folder(), std::uint64_t{1} << 24U});
        if (!model) {
            EXPECT_FALSE(model.error().message.empty());
            EXPECT_EQ(model.error().message.find('\n'), std::string::npos) << model.error().message;
            return model;
        }
        EXPECT_LE(model->triangles.size(), content.size());
        // zeros that are nowhere stored are the exception
        EXPECT_LE(model->positions.size(), content.size() + (1U << 20U));
        (void)voxels::inspect(*model); // counts what is out of range
        return model;
    }
};

std::string gzipped(const std::string& text)
{
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    std::string packed(deflateBound(&stream, text.size()) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(packed.data());
    stream.avail_out = static_cast<uInt>(packed.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    packed.resize(stream.total_out);
    deflateEnd(&stream);
    return packed;
}

} // namespace

TEST_F(ModelFileTest, readsWhatIsWritten)
{
    const std::vector<surface::TriangleMesh> meshes{
        oneTriangle(),
        ball({1.0 / 3, -2, 1e-3}, 10, 24),
        randomMesh(1, 500, 300, {-1e3, 1e3, 0.1}, 1e3),
        randomMesh(2, 65536, 21845, {5, 6, 7}, 100)};
    for (const surface::TriangleMesh& mesh : meshes) {
        for (const std::string format : kFormats) {
            const auto written = writeMesh(mesh, path("mesh" + format));
            ASSERT_TRUE(written) << written.error().message;
            const voxels::TriangleModel model = read("mesh" + format);
            ASSERT_EQ(model.triangles.size(), mesh.indices.size() / 3) << format;
            if (format != ".stl") { // which has no shared vertices
                ASSERT_EQ(model.positions.size(), mesh.positions.size()) << format;
            }
            const double allowed =
                format == ".ply" || format == ".obj" ? 0 : written->positionError;
            for (std::size_t i = 0; i < mesh.indices.size(); ++i) {
                const std::uint32_t corner = model.triangles[i / 3][i % 3];
                if (format != ".stl") {
                    ASSERT_EQ(corner, mesh.indices[i]) << format;
                }
                ASSERT_LT(corner, model.positions.size());
                const glm::dvec3 off =
                    glm::abs(model.positions[corner] - mesh.positions[mesh.indices[i]]);
                ASSERT_LE(std::max({off.x, off.y, off.z}), allowed) << format;
            }
            EXPECT_EQ(voxels::inspect(model).outOfRange, 0U);
            EXPECT_TRUE(model.notes.empty());
        }
    }
}

TEST_F(ModelFileTest, unpacksWhatIsGzippedAndKeepsALimit)
{
    for (const std::string format : kFormats) {
        const std::string plain = smallFile(format);
        setContent(path("packed" + format + ".gz"), gzipped(plain));
        EXPECT_EQ(read("packed" + format + ".gz").triangles, read("small" + format).triangles);
        const auto limited = readModel(path("packed" + format + ".gz"), plain.size() - 1);
        ASSERT_FALSE(limited) << format;
        EXPECT_EQ(limited.error().code, core::ErrorCode::resourceLimit) << format;
        EXPECT_TRUE(isModelName("a/b" + format)) << format;
    }
    EXPECT_TRUE(isModelName("B.GLTF.gz"));
    EXPECT_FALSE(isModelName("ply"));
    EXPECT_FALSE(isModelName("a.nrrd"));
    EXPECT_EQ(readModel(path("a.txt")).error().code, core::ErrorCode::usage);
    setContent(path("bad.ply"), "plyers");
    EXPECT_NE(readModel(path("bad.ply")).error().message.find("bad.ply: "), std::string::npos);
    EXPECT_EQ(readModel(path("none.ply")).error().code, core::ErrorCode::inputOutput);
}

TEST_F(ModelFileTest, readsRealMeshesAsTheyAreKnown)
{
    const char* const data = std::getenv("ISOFRONT_TEST_DATA");
    if (data == nullptr)
        GTEST_SKIP() << "ISOFRONT_TEST_DATA names no folder with meshes";
    struct Known {
        const char* name;
        std::size_t positions, triangles;
        std::uint64_t open, nonManifold, degenerate;
    };
    for (const Known& known :
         {Known{"meshes/stanford_dragon_871k.ply.gz", 437645, 871414, 0, 0, 108},
          Known{"meshes/stanford_dragon_res2_202k_nonmanifold.ply.gz", 100250, 202520, 0, 2534, 0},
          Known{"meshes/stanford_bunny_69k_holes.ply.gz", 35947, 69451, 223, 0, 0},
          Known{"meshes/bunny_closed_75k.ply.gz", 37706, 75408, 0, 0, 0},
          Known{"meshes/armadillo_86k.ply.gz", 43243, 86482, 0, 0, 0},
          Known{"skinned/CesiumMan.glb", 3273, 4672, 0, 0, 0},
          Known{"skinned/Fox.glb", 1728, 576, 0, 0, 0}}) {
        const auto model = readModel(std::filesystem::path(data) / known.name);
        ASSERT_TRUE(model) << model.error().message;
        EXPECT_EQ(model->positions.size(), known.positions) << known.name;
        EXPECT_EQ(model->triangles.size(), known.triangles) << known.name;
        const voxels::ModelReport report = voxels::inspect(*model);
        EXPECT_EQ(report.outOfRange + report.notFinite, 0U) << known.name;
        if (std::string_view(known.name).starts_with("meshes")) {
            EXPECT_EQ(report.openEdges, known.open) << known.name;
            EXPECT_EQ(report.nonManifoldEdges, known.nonManifold) << known.name;
            EXPECT_EQ(report.degenerate, known.degenerate) << known.name;
        } else {
            ASSERT_EQ(model->textures.size(), 1U) << known.name;
            EXPECT_EQ(model->textureOf.size(), known.triangles);
            EXPECT_GE(model->textures[0].image.width, 64);
        }
    }
    // upright, by its joints: stored it lies on its back
    const auto man = readModel(std::filesystem::path(data) / "skinned/CesiumMan.glb");
    const core::Box box = voxels::inspect(*man).bounds;
    EXPECT_NEAR(box.low.y, 0, 1e-3);
    EXPECT_NEAR(box.high.y, 1.51, 0.01);
    EXPECT_NEAR(box.high.x, -box.low.x, 1e-3);
}

TEST_F(ModelFileTest, saysWhatIsWrongWithWhatWasCutShort)
{
    for (const std::string format : kFormats) {
        const std::string whole = smallFile(format);
        const std::size_t triangles = read("small" + format).triangles.size();
        // text may end after any line; a binary file may not
        const bool mayEnd = format == ".obj";
        for (std::size_t length = 0; length < whole.size(); ++length) {
            const auto model = readBytes(format, whole.substr(0, length));
            ASSERT_TRUE(mayEnd || !model || model->triangles.size() == triangles)
                << format << " " << length;
        }
    }
}

TEST_F(ModelFileTest, readsObjLinesThatGoOnInTheNext)
{
    const std::string plain = "mtllib m.mtl\n# a comment\nv 0 0 0\nv 1 0 0 0.5 0.25 1\nv 0 1 0\n"
                              "v 0 0 1\nf 1 2 3 4\nf -1 -2 -3\n";
    setContent(path("m.mtl"), "");
    setContent(path("plain.obj"), plain);
    const voxels::TriangleModel expected = read("plain.obj");
    ASSERT_EQ(expected.triangles.size(), 3U);
    for (const std::string end : {"\\\n", " \\\n", "\\\r\n", "\\\n \\\n\t"}) {
        // at any one blank, and at all of them at once; a comment ends where its line does
        std::string all;
        for (std::size_t i = 0; i < plain.size(); ++i) {
            const bool isName = i < plain.find('v', 20);
            all += plain[i] == ' ' && !isName ? end + " " : std::string(1, plain[i]);
            if (plain[i] != ' ' || isName)
                continue;
            setContent(path("one.obj"), plain.substr(0, i) + end + plain.substr(i));
            EXPECT_EQ(read("one.obj").positions, expected.positions) << i;
            EXPECT_EQ(read("one.obj").triangles, expected.triangles) << i;
        }
        setContent(path("all.obj"), all);
        EXPECT_EQ(read("all.obj").positions, expected.positions);
        EXPECT_EQ(read("all.obj").triangles, expected.triangles);
    }
    setContent(path("comment.obj"), "# a comment \\\n" + plain + "f 1 2\\");
    EXPECT_EQ(read("comment.obj").triangles, expected.triangles);
    const auto bad = readBytes(".obj", "v 0 0 0\nv 1 \\\n1 \\\n1\nv x 0 0\n");
    ASSERT_FALSE(bad);
    EXPECT_NE(bad.error().message.find("line 5"), std::string::npos) << bad.error().message;
}

TEST_F(ModelFileTest, standsAnyDamage)
{
    auto random = tests::random(11);
    for (const std::string format : kFormats) {
        const std::string whole = smallFile(format);
        for (int trial = 0; trial < tests::trials(600); ++trial) {
            std::string other = whole;
            for (std::size_t i = 1 + tests::below(random, 4); i > 0; --i) {
                const std::size_t at = tests::below(random, other.size());
                switch (tests::below(random, 4)) {
                case 0:
                    other[at] = static_cast<char>(random());
                    break;
                case 1:
                    other.insert(at, 1, "0123456789-+.e/\n{}[],\"\\"[tests::below(random, 23)]);
                    break;
                case 2:
                    other.erase(at, 1 + tests::below(random, 8));
                    break;
                default:
                    other[at] = "0189-\n\xff\x7f"[tests::below(random, 8)];
                }
                if (other.empty())
                    break;
            }
            (void)readBytes(format, other);
        }
    }
}

TEST_F(ModelFileTest, doesNotBelieveCountsThatLie)
{
    const std::string ply = "ply\nformat binary_little_endian 1.0\nelement vertex ";
    const std::string properties =
        "\nproperty float x\nproperty float y\nproperty float z\nelement face 4000000000\n"
        "property list uint int vertex_indices\nend_header\n";
    for (const char* const count : {"4000000000", "18446744073709551615", "99999999999999999999"})
        (void)readBytes(".ply", ply + count + properties + std::string(64, '\x7f'));
    // a list that says it is four billion long
    (void)readBytes(
        ".ply", ply + "1" + properties + std::string(12, '\0') + std::string(4, '\xff'));
    std::string stl(84 + 50, '\0');
    stl.replace(80, 4, "\xff\xff\xff\xff", 4);
    (void)readBytes(".stl", stl);
    (void)readBytes(
        ".obj", "v 1 2 3\nf 4000000000 -4000000000 99999999999\nf 1 1 -9223372036854775808\n");
    std::string glb = smallFile(".glb");
    for (const std::size_t at : {8U, 12U}) {
        std::string lie = glb;
        lie.replace(at, 4, "\xf0\xff\xff\xff", 4);
        EXPECT_FALSE(readBytes(".glb", lie));
    }
}

TEST_F(ModelFileTest, holdsToItsLimitWhereAFewBytesAreATriangle)
{
    std::string corners;
    for (int i = 0; i < 10'000; ++i)
        corners += " 1";
    const std::string ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                            "property float y\nproperty float z\nelement face 1\n"
                            "property list int int vertex_indices\nend_header\n1 2 3\n10000" +
                            corners + "\n";
    std::string facets = "solid\n";
    std::string vertices;
    std::string places;
    for (int i = 0; i < 3000; ++i) {
        const std::string number = std::to_string(i);
        facets += "vertex " + number + " 1 1\n";
        vertices += "v 1 1 " + number + '\n';
        places += "vt 1\n";
    }
    const std::pair<const char*, std::string> files[] = {
        {"face.ply", ply},
        {"facets.stl", facets + "endsolid\n"},
        {"face.obj", "v 1 2 3\nf" + corners + '\n'},
        {"vertices.obj", vertices},
        {"places.obj", places}};
    for (const auto& [name, content] : files) {
        setContent(path(name), content);
        EXPECT_TRUE(readModel(path(name), 20 * content.size())) << name;
        const auto limited = readModel(path(name), content.size());
        ASSERT_FALSE(limited) << name;
        EXPECT_EQ(limited.error().code, core::ErrorCode::resourceLimit) << name;
        EXPECT_NE(limited.error().message.find("--memory-limit"), std::string::npos)
            << limited.error().message;
    }
}

/// Files of many pages are given back to the system while they are read; nothing of them is lost.
TEST_F(ModelFileTest, readsAllOfALargeFile)
{
    constexpr std::uint32_t kCount = 150'000;
    std::string content =
        "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(kCount) +
        "\nproperty float x\nproperty float y\nproperty float z\n"
        "element face " +
        std::to_string(kCount) + "\nproperty list uchar uint vertex_indices\nend_header\n";
    const auto add = [&](const auto& value) {
        content.append(reinterpret_cast<const char*>(&value), sizeof(value));
    };
    const auto corner = [](std::uint32_t i, std::uint32_t k) { return (7 * i + k) % kCount; };
    for (std::uint32_t i = 0; i < kCount; ++i)
        for (const float scale : {1.0F, -2.0F, 3.0F})
            add(scale * static_cast<float>(i));
    for (std::uint32_t i = 0; i < kCount; ++i) {
        add(std::uint8_t{3});
        for (std::uint32_t k = 0; k < 3; ++k)
            add(corner(i, k));
    }
    std::ofstream(path("large.ply"), std::ios::binary) << content;
    const voxels::TriangleModel model = read("large.ply");
    ASSERT_EQ(model.positions.size(), kCount);
    ASSERT_EQ(model.triangles.size(), kCount);
    for (std::uint32_t i = 0; i < kCount; ++i) {
        const double x = i;
        ASSERT_EQ(model.positions[i], glm::dvec3(x, -2 * x, 3 * x));
        for (std::uint32_t k = 0; k < 3; ++k)
            ASSERT_EQ(model.triangles[i][k], corner(i, k));
    }
}

TEST_F(ModelFileTest, keepsPositionsThatAreNoNumbersForTheReport)
{
    setContent(
        path("nan.obj"), "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 1e999 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 9\n");
    const voxels::ModelReport report = voxels::inspect(read("nan.obj"));
    EXPECT_EQ(report.triangles, 3U);
    EXPECT_EQ(report.notFinite + report.outOfRange, 3U);
    EXPECT_EQ(report.outOfRange, 1U);
    EXPECT_TRUE(report.bounds.isEmpty());
}

TEST_F(ModelFileTest, takesMaterialsOfObj)
{
    setContent(
        path("m.mtl"),
        "newmtl red\nKd 1 0 0\nnewmtl with picture\nKd 1 1 1\nmap_Kd -s 1 1 1 gone.png\n");
    setContent(
        path("m.obj"),
        "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.25 0\nvt 1 0.5\nvt 0 1\n"
        "f 1 2 3\nusemtl red\nf 1/1 2/2 3/3\nusemtl with picture\nf 1/1/1 2/2/1 3/-1/1\n"
        "usemtl unknown\nf 1 2 3\n");
    const voxels::TriangleModel model = read("m.obj");
    ASSERT_EQ(model.textures.size(), 2U);
    EXPECT_EQ(model.textures[0].image.rgba, (std::vector<std::uint8_t>{255, 0, 0, 255}));
    EXPECT_EQ(
        model.textureOf,
        (std::vector<std::uint32_t>{voxels::kNoTexture, 0, 1, voxels::kNoTexture}));
    ASSERT_EQ(model.textureCorners.size(), 4U);
    EXPECT_EQ(model.textureCorners[1][0], glm::vec2(0.25F, 1)) << "from the top down";
    EXPECT_EQ(model.textureCorners[2][2], glm::vec2(0, 0));
    ASSERT_EQ(model.notes.size(), 1U);
    EXPECT_NE(model.notes[0].find("gone.png"), std::string::npos) << model.notes[0];
    setContent(path("m.mtl"), "");
    EXPECT_FALSE(read("m.obj").isColoured());
    std::filesystem::remove(path("m.mtl"));
    ASSERT_EQ(read("m.obj").notes.size(), 1U);
    EXPECT_NE(read("m.obj").notes[0].find("m.mtl"), std::string::npos);
}

} // namespace isofront::exchange::test
