// glTF put together: each feature against what it says by its definition.

#include "ExchangeFixture.h"
#include "models/ModelFormats.h"
#include "models/Picture.h"
#include "support/Random.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/exchange/Png.h>

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <string>
#include <vector>

namespace isofront::exchange::test {

namespace {

using Json = nlohmann::json;
using Triangle = std::array<glm::dvec3, 3>;

/// A scene that is built up piece by piece, with one buffer in a file beside it.
class GltfModelTest : public ExchangeTest {
protected:
    GltfModelTest()
    {
        gltf["asset"]["version"] = "2.0";
        gltf["scene"] = 0;
        gltf["scenes"] = Json::array({{{"nodes", {0}}}});
        gltf["nodes"] = Json::array({{{"mesh", 0}}});
    }

    template <typename T>
    std::size_t view(const std::vector<T>& values, std::size_t stride = 0)
    {
        Json json{
            {"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (stride > 0)
            json["byteStride"] = stride;
        const std::size_t begin = bytes.size();
        bytes.resize(begin + values.size() * sizeof(T));
        std::memcpy(bytes.data() + begin, values.data(), values.size() * sizeof(T));
        bytes.resize((bytes.size() + 3) / 4 * 4);
        gltf["bufferViews"].push_back(json);
        return gltf["bufferViews"].size() - 1;
    }
    std::size_t accessor(
        std::size_t ofView,
        std::size_t count,
        const char* type,
        int component,
        const Json& more = {})
    {
        Json json{
            {"bufferView", ofView}, {"count", count}, {"type", type}, {"componentType", component}};
        if (more.is_object())
            json.update(more);
        gltf["accessors"].push_back(json);
        return gltf["accessors"].size() - 1;
    }
    std::size_t floats(const std::vector<float>& values, const char* type, std::size_t components)
    {
        return accessor(view(values), values.size() / components, type, 5126);
    }
    void primitive(const Json& json) { gltf["meshes"][0]["primitives"].push_back(json); }

    [[nodiscard]] core::Result<voxels::TriangleModel> readResult()
    {
        setContent(path("scene.bin"), bytes);
        if (!bytes.empty())
            gltf["buffers"] = Json::array({{{"uri", "scene.bin"}, {"byteLength", bytes.size()}}});
        setContent(path("scene.gltf"), gltf.dump());
        return readModel(path("scene.gltf"));
    }
    voxels::TriangleModel read()
    {
        auto model = readResult();
        EXPECT_TRUE(model) << model.error().message;
        return model ? std::move(*model) : voxels::TriangleModel();
    }
    static std::vector<Triangle> trianglesOf(const voxels::TriangleModel& model)
    {
        std::vector<Triangle> triangles;
        for (const auto& t : model.triangles)
            triangles.push_back(
                {model.positions.at(t[0]), model.positions.at(t[1]), model.positions.at(t[2])});
        return triangles;
    }
    static glm::dvec3 normalOf(const Triangle& t) { return glm::cross(t[1] - t[0], t[2] - t[0]); }

    /// Five corners of a strip in the plane z = 0 whose triangles face up.
    std::vector<float> stripCorners() const
    {
        return {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    }

    Json gltf;
    std::string bytes;
};

} // namespace

TEST_F(GltfModelTest, makesTrianglesOfStripsAndFans)
{
    const auto strip = floats(stripCorners(), "VEC3", 3);
    const auto fan = floats({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 0, 0}, "VEC3", 3);
    primitive({{"attributes", {{"POSITION", strip}}}, {"mode", 5}});
    primitive({{"attributes", {{"POSITION", fan}}}, {"mode", 6}});
    const auto indices = accessor(view<std::uint16_t>({0, 1, 2, 2, 1, 3}), 6, "SCALAR", 5123);
    primitive({{"attributes", {{"POSITION", strip}}}, {"indices", indices}});
    primitive({{"attributes", {{"POSITION", strip}}}, {"mode", 1}});
    const voxels::TriangleModel model = read();
    const auto triangles = trianglesOf(model);
    ASSERT_EQ(triangles.size(), 3U + 3U + 2U);
    double area = 0;
    for (const Triangle& t : triangles) {
        EXPECT_GT(normalOf(t).z, 0) << "all face up";
        area += normalOf(t).z / 2;
    }
    EXPECT_DOUBLE_EQ(area, 1.5 + 1.5 + 1);
    EXPECT_EQ(triangles[6], triangles[0]) << "the list is the strip's beginning";
    EXPECT_EQ(model.notes, std::vector<std::string>{"points and lines are left out"});
    EXPECT_FALSE(model.isColoured());
}

TEST_F(GltfModelTest, findsNumbersHoweverTheyAreStored)
{
    const std::vector<float> corners{0, 0, 0, 1, 0, 0, 0, 1, 0};
    // interleaved with a fourth number
    const auto woven = accessor(
        view<float>({9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0}, 16),
        3,
        "VEC3",
        5126,
        {{"byteOffset", 4}});
    // shares of 32767 and 255, the latter four bytes apart
    const auto shorts = accessor(
        view<std::int16_t>({0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0}, 8),
        3,
        "VEC3",
        5122,
        {{"normalized", true}});
    const auto octets = accessor(
        view<std::uint8_t>({0, 0, 0, 0, 255, 0, 0, 0, 0, 255, 0, 0}, 4),
        3,
        "VEC3",
        5121,
        {{"normalized", true}});
    // plain integers
    const auto integers =
        accessor(view<std::int8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, 4), 3, "VEC3", 5120);
    // zeros but for two, and all but for two
    const auto sparse = [&](bool onZeros) {
        const auto which = view<std::uint8_t>({1, 2});
        const auto values = view<float>({1, 0, 0, 0, 1, 0});
        const auto base = floats({0, 0, 0, 7, 7, 7, 8, 8, 8}, "VEC3", 3);
        Json& json = gltf["accessors"][base];
        if (onZeros)
            json.erase("bufferView");
        json["sparse"] = {
            {"count", 2},
            {"indices", {{"bufferView", which}, {"componentType", 5121}}},
            {"values", {{"bufferView", values}}}};
        return base;
    };
    for (const std::size_t position :
         {floats(corners, "VEC3", 3), woven, shorts, octets, integers, sparse(true), sparse(false)})
        primitive({{"attributes", {{"POSITION", position}}}});
    for (const int type : {5121, 5123, 5125}) {
        const std::size_t ofView = type == 5121   ? view<std::uint8_t>({0, 1, 2})
                                   : type == 5123 ? view<std::uint16_t>({0, 1, 2})
                                                  : view<std::uint32_t>({0, 1, 2});
        primitive(
            {{"attributes", {{"POSITION", woven}}},
             {"indices", accessor(ofView, 3, "SCALAR", type)}});
    }
    const auto triangles = trianglesOf(read());
    ASSERT_EQ(triangles.size(), 10U);
    for (const Triangle& t : triangles)
        EXPECT_EQ(t, (Triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}}));
}

TEST_F(GltfModelTest, placesNodesAndKeepsMirroredOnesFacingOut)
{
    primitive({{"attributes", {{"POSITION", floats({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 3)}}}});
    const double half = std::sqrt(0.5);
    // a turn by 90 degrees about z, with a child at twice the size, further out
    gltf["nodes"] = Json::array(
        {{{"rotation", {0, 0, half, half}}, {"translation", {10, 0, 0}}, {"children", {1, 2}}},
         {{"mesh", 0}, {"scale", {2, 2, 2}}, {"translation", {1, 0, 0}}},
         {{"mesh", 0}, {"matrix", {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 5, 1}}},
         {{"mesh", 0}}}); // in no scene
    const auto triangles = trianglesOf(read());
    ASSERT_EQ(triangles.size(), 2U);
    const auto expectNear = [](const glm::dvec3& a, const glm::dvec3& b) {
        EXPECT_LT(glm::distance(a, b), 1e-12) << a.x << " " << a.y << " " << a.z;
    };
    // (x, y, z) -> (10 - y', x', z') of what the child makes of it
    const std::size_t child = glm::distance(triangles[0][0], {10, 3, 0}) < 1e-9 ? 0 : 1;
    expectNear(triangles[child][0], {10, 3, 0});
    expectNear(triangles[child][1], {8, 1, 0});
    expectNear(triangles[child][2], {10, 1, 2});
    const Triangle& mirrored = triangles[1 - child];
    expectNear(mirrored[0], {10, -1, 5});
    // outward stays outward: (1, 1, 1) becomes (-1, 1, 1), and turned (-1, -1, 1)
    EXPECT_GT(glm::dot(normalOf(mirrored), {-1, -1, 1}), 1.0);
}

TEST_F(GltfModelTest, movesVerticesByTheirJoints)
{
    const auto positions = floats({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3", 3);
    // all by the first, all by the second, and half and half
    const auto joints =
        accessor(view<std::uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}), 3, "VEC4", 5121);
    const auto weights = floats({1, 0, 0, 0, 1, 0, 0, 0, 0.5, 0.5, 0, 0}, "VEC4", 4);
    std::vector<float> inverse(32);
    for (std::size_t i : {0U, 5U, 10U, 15U, 16U, 21U, 26U, 31U})
        inverse[i] = 1;
    inverse[12] = -100; // the first joint stood at x = 100 when it was bound
    primitive(
        {{"attributes", {{"POSITION", positions}, {"JOINTS_0", joints}, {"WEIGHTS_0", weights}}}});
    gltf["skins"] =
        Json::array({{{"joints", {1, 2}}, {"inverseBindMatrices", floats(inverse, "MAT4", 16)}}});
    gltf["nodes"] = Json::array(
        {{{"mesh", 0}, {"skin", 0}, {"translation", {7, 7, 7}}, {"children", {1, 2}}},
         {{"translation", {93, -7, 3}}},    // now at (100, 0, 10)
         {{"translation", {-7, -7, 13}}}}); // at (0, 0, 20)
    const auto triangles = trianglesOf(read());
    ASSERT_EQ(triangles.size(), 1U);
    EXPECT_EQ(triangles[0][0], glm::dvec3(1, 0, 10)) << "the node's own place doesn't count";
    EXPECT_EQ(triangles[0][1], glm::dvec3(0, 1, 20));
    EXPECT_EQ(triangles[0][2], glm::dvec3(0, 0, 16));
    gltf["skins"][0]["joints"] = {1};
    EXPECT_FALSE(readResult()) << "a joint that is not there";
}

TEST_F(GltfModelTest, multipliesFactorsAndColoursAsLight)
{
    const auto positions = floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
    const auto colours = floats({1, 1, 1, 0.5, 0.5, 0.5, 0, 2, -1}, "VEC3", 3);
    const auto bytesOfColours = accessor(
        view<std::uint8_t>({255, 0, 255, 128, 0, 0, 0, 0, 255, 255, 255, 255}),
        3,
        "VEC4",
        5121,
        {{"normalized", true}});
    gltf["materials"] = Json::array(
        {{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 0.5, 0, 0.5}}}}},
         {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}},
          {"alphaMode", "BLEND"}}});
    primitive({{"attributes", {{"POSITION", positions}, {"COLOR_0", colours}}}});
    primitive({{"attributes", {{"POSITION", positions}}}, {"material", 0}});
    primitive(
        {{"attributes", {{"POSITION", positions}, {"COLOR_0", bytesOfColours}}}, {"material", 1}});
    const voxels::TriangleModel model = read();
    // a linear half is sRGB 188
    EXPECT_EQ(
        model.colours,
        (std::vector<std::uint32_t>{
            0xffffffff,
            0xffbcbcbc,
            0xff00ff00,
            0xff00bcff,
            0xff00bcff,
            0xff00bcff,
            0x40ff00ff,
            0x00000000,
            0x80ffffff}));
}

TEST_F(GltfModelTest, takesTexturesAndTellsOfThoseItCant)
{
    core::Image picture{3, 2, {}};
    for (int i = 0; i < 6; ++i)
        for (const int value : {10 * i, 100, 255 - i, 128})
            picture.rgba.push_back(static_cast<std::uint8_t>(value));
    ASSERT_TRUE(writePng(picture, path("my picture.png")));
    const std::string png = contentOf(path("my picture.png"));
    const auto embedded = view(std::vector<char>(png.begin(), png.end()));
    gltf["images"] = Json::array(
        {{{"uri", "my%20picture.png"}},
         {{"bufferView", embedded}, {"mimeType", "image/png"}},
         {{"uri", "gone.png"}}});
    gltf["samplers"] = Json::array({{{"wrapS", 33071}, {"wrapT", 33648}}});
    gltf["textures"] = Json::array(
        {{{"source", 0}}, {{"source", 1}, {"sampler", 0}}, {{"source", 2}}, {{"sampler", 0}}});
    const auto material = [](int texture, const char* alpha) {
        return Json{
            {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}},
            {"alphaMode", alpha}};
    };
    gltf["materials"] = Json::array(
        {material(0, "OPAQUE"),
         material(1, "BLEND"),
         material(2, "OPAQUE"),
         material(3, "OPAQUE"),
         material(0, "OPAQUE")});
    const auto positions = floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3", 3);
    const auto places = floats({0, 0.5, 1, 2, -3, 0.25}, "VEC2", 2);
    for (int i = 0; i < 5; ++i)
        primitive(
            {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", places}}}, {"material", i}});
    primitive({{"attributes", {{"POSITION", positions}}}, {"material", 0}});
    const voxels::TriangleModel model = read();
    constexpr std::uint32_t kNone = voxels::kNoTexture;
    EXPECT_EQ(model.textureOf, (std::vector<std::uint32_t>{0, 1, kNone, kNone, 0, kNone}));
    ASSERT_EQ(model.textures.size(), 2U);
    EXPECT_EQ(model.textures[1].image.rgba, picture.rgba);
    EXPECT_EQ(model.textures[1].acrossX, voxels::Texture::Wrap::clamp);
    EXPECT_EQ(model.textures[1].acrossY, voxels::Texture::Wrap::mirror);
    EXPECT_EQ(model.textures[0].acrossX, voxels::Texture::Wrap::repeat);
    for (std::size_t i = 0; i < picture.rgba.size(); ++i)
        EXPECT_EQ(model.textures[0].image.rgba[i], i % 4 == 3 ? 255 : picture.rgba[i]) << "opaque";
    EXPECT_EQ(
        model.textureCorners[1],
        (std::array<glm::vec2, 3>{glm::vec2(0, 0.5F), glm::vec2(1, 2), glm::vec2(-3, 0.25F)}));
    EXPECT_TRUE(model.colours.empty());
    ASSERT_EQ(model.notes.size(), 3U);
    for (const char* part : {"texture 2", "texture 3", "TEXCOORD_0"})
        EXPECT_TRUE(std::ranges::any_of(model.notes, [&](const std::string& note) {
            return note.find(part) != std::string::npos;
        })) << part;
}

TEST_F(GltfModelTest, refusesWhatContradictsItself)
{
    const auto positions = floats(stripCorners(), "VEC3", 3);
    const auto indices =
        accessor(view<std::uint32_t>({0, 1, 2, 4, 5, 0xffffffffU}), 6, "SCALAR", 5125);
    primitive({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
    const Json good = gltf;
    const voxels::TriangleModel model = read();
    EXPECT_EQ(voxels::inspect(model).outOfRange, 1U) << "an index past the part's vertices";
    const auto expectRefused = [&](const char* what, const auto& change, core::ErrorCode code) {
        gltf = good;
        change();
        const auto result = readResult();
        ASSERT_FALSE(result) << what;
        EXPECT_EQ(result.error().code, code) << what << ": " << result.error().message;
        EXPECT_NE(result.error().message.find("scene.gltf"), std::string::npos);
        EXPECT_NE(result.error().message.find(what), std::string::npos) << result.error().message;
    };
    using core::ErrorCode;
    const auto bad = ErrorCode::badData;
    expectRefused(
        "accessor 0", [&] { gltf["accessors"][0]["count"] = 6; }, bad);
    expectRefused(
        "accessor 0", [&] { gltf["accessors"][0]["count"] = 1ULL << 62U; }, bad);
    expectRefused(
        "accessor 0", [&] { gltf["accessors"][0]["type"] = "VEC2"; }, bad);
    expectRefused(
        "accessor 0", [&] { gltf["accessors"][0]["componentType"] = 5130; }, bad);
    expectRefused(
        "accessor 0",
        [&] {
            gltf["accessors"][0].erase("bufferView"), gltf["accessors"][0]["count"] = 1U << 30U;
        },
        bad);
    expectRefused(
        "accessor", [&] { gltf["meshes"][0]["primitives"][0]["indices"] = 9; }, bad);
    for (const int type : {5120, 5122, 5126}) // bytes and shorts with a sign, and floats
        expectRefused(
            "sign", [&] { gltf["accessors"][indices]["componentType"] = type; }, bad);
    expectRefused(
        "buffer view 0", [&] { gltf["bufferViews"][0]["byteLength"] = 1U << 30U; }, bad);
    expectRefused(
        "buffer view 0", [&] { gltf["bufferViews"][0]["byteOffset"] = 1ULL << 40U; }, bad);
    expectRefused(
        "node 0", [&] { gltf["nodes"][0]["children"] = {0}; }, bad);
    expectRefused(
        "node 4", [&] { gltf["nodes"][0]["children"] = {4}; }, bad);
    expectRefused(
        "mesh 3", [&] { gltf["nodes"][0]["mesh"] = 3; }, bad);
    expectRefused(
        "material 5", [&] { gltf["meshes"][0]["primitives"][0]["material"] = 5; }, bad);
    expectRefused(
        "KHR_draco", [&] { gltf["extensionsRequired"] = {"KHR_draco_mesh_compression"}; }, bad);
    gltf = good;
    gltf["extensionsRequired"] = {"KHR_materials_unlit", "KHR_mesh_quantization"};
    EXPECT_TRUE(readResult());

    gltf = good;
    ASSERT_TRUE(readResult());
    std::filesystem::remove(path("scene.bin"));
    const auto missing = readModel(path("scene.gltf"));
    ASSERT_FALSE(missing);
    EXPECT_EQ(missing.error().code, ErrorCode::inputOutput);
    EXPECT_NE(missing.error().message.find("scene.bin"), std::string::npos)
        << missing.error().message;

    setContent(
        path("deep.gltf"),
        R"({"asset": {"version": "2.0"}, "extras": )" + std::string(200'000, '[') +
            std::string(200'000, ']') + "}");
    EXPECT_EQ(readModel(path("deep.gltf")).error().code, bad);
}

TEST_F(GltfModelTest, holdsToItsLimitThroughManyInstances)
{
    std::vector<float> corners(3'000);
    const auto positions = floats(corners, "VEC3", 3);
    primitive({{"attributes", {{"POSITION", positions}}}});
    gltf["nodes"] = Json::array();
    gltf["scenes"][0]["nodes"] = Json::array();
    for (int node = 0; node < 1000; ++node) {
        gltf["nodes"].push_back({{"mesh", 0}});
        gltf["scenes"][0]["nodes"].push_back(node);
    }
    EXPECT_EQ(read().positions.size(), 1'000'000U);
    const auto limited = readModel(path("scene.gltf"), 1 << 20);
    ASSERT_FALSE(limited);
    EXPECT_EQ(limited.error().code, core::ErrorCode::resourceLimit);
}

TEST_F(GltfModelTest, standsAnyDamageToItsText)
{
    auto random = tests::random(12);
    const auto positions = floats(stripCorners(), "VEC3", 3);
    const auto indices = accessor(view<std::uint8_t>({0, 1, 2, 2, 1, 3}), 6, "SCALAR", 5121);
    gltf["accessors"][positions]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", 1}, {"componentType", 5121}}},
        {"values", {{"bufferView", 0}}}};
    gltf["materials"] = Json::array(
        {{{"pbrMetallicRoughness",
           {{"baseColorFactor", {1, 0.5, 0, 0.5}}, {"baseColorTexture", {{"index", 0}}}}}}});
    gltf["textures"] = Json::array({{{"source", 0}}});
    gltf["images"] = Json::array({{{"bufferView", 0}, {"mimeType", "image/png"}}});
    gltf["skins"] = Json::array({{{"joints", {0}}}});
    primitive(
        {{"attributes",
          {{"POSITION", positions}, {"TEXCOORD_0", positions}, {"JOINTS_0", indices}}},
         {"indices", indices},
         {"material", 0}});
    (void)readResult();
    const std::string whole = contentOf(path("scene.gltf"));
    for (int trial = 0; trial < tests::trials(1500); ++trial) {
        std::string other = whole;
        for (std::size_t i = 1 + tests::below(random, 3); i > 0; --i) {
            const std::size_t at = tests::below(random, other.size());
            const bool isDigit = other[at] >= '0' && other[at] <= '9';
            if (isDigit || trial % 3 == 0)
                other.replace(
                    at,
                    1,
                    std::vector<std::string>{
                        "-1", "9", "4294967295", "1e300", "null", "{}", "\"", ""}[tests::below(
                        random, 8)]);
        }
        const auto model =
            readGltf(std::as_bytes(std::span(other)), {folder(), std::uint64_t{1} << 24U});
        if (model)
            (void)voxels::inspect(*model);
        else
            ASSERT_FALSE(model.error().message.empty());
    }
}

TEST_F(GltfModelTest, refusesPicturesThatHideTheirSize)
{
    const core::Image picture{33, 17, std::vector<std::uint8_t>(std::size_t{33} * 17 * 4, 99)};
    ASSERT_TRUE(writePng(picture, path("p.png")));
    // a picture that hides its size behind another chunk, as some telephones write it: 1 x 1 is
    // what stands where the size has to be
    std::string hidden = contentOf(path("p.png"));
    const std::size_t data = hidden.find("IDAT");
    ASSERT_NE(data, std::string::npos);
    std::uint32_t length = 0;
    for (std::size_t i = 4; i > 0; --i)
        length = length << 8U | static_cast<unsigned char>(hidden[data - i]);
    length -= 2; // their data have no zlib header
    for (std::size_t i = 1; i <= 4; ++i, length >>= 8U)
        hidden[data - i] = static_cast<char>(length & 0xffU);
    hidden.erase(data + 4, 2);
    hidden.insert(8, std::string("\0\0\0\4CgBI\0\0\0\1\0\0\0\1", 16));
    const auto decoded = decodePicture(std::as_bytes(std::span(hidden)), 4);
    ASSERT_FALSE(decoded);
    EXPECT_EQ(decoded.error().code, core::ErrorCode::badData);
}

TEST_F(GltfModelTest, decodesPicturesOrSaysWhyNot)
{
    core::Image picture{33, 17, {}};
    auto random = tests::random(13);
    for (int i = 0; i < 33 * 17 * 4; ++i)
        picture.rgba.push_back(static_cast<std::uint8_t>(random()));
    ASSERT_TRUE(writePng(picture, path("p.png")));
    const auto read = readPicture(path("p.png"), 1 << 20);
    ASSERT_TRUE(read) << read.error().message;
    EXPECT_EQ(read->rgba, picture.rgba);
    EXPECT_EQ(
        readPicture(path("p.png"), 33 * 17 * 4 - 1).error().code, core::ErrorCode::resourceLimit);
    EXPECT_EQ(readPicture(path("q.png"), 1000).error().code, core::ErrorCode::inputOutput);

    std::vector<std::string> pictures{contentOf(path("p.png"))};
    if (const char* const data = std::getenv("ISOFRONT_TEST_DATA")) {
        const std::string glb = contentOf(std::filesystem::path(data) / "skinned/CesiumMan.glb");
        pictures.push_back(glb.substr(glb.find("\xff\xd8\xff"))); // a JPEG picture, at the end
        const auto jpeg = decodePicture(std::as_bytes(std::span(pictures.back())), 1 << 28);
        ASSERT_TRUE(jpeg) << jpeg.error().message;
        EXPECT_EQ(jpeg->width, jpeg->height);
        EXPECT_EQ(jpeg->rgba.size(), 4U * static_cast<unsigned>(jpeg->width * jpeg->height));
    }
    for (const std::string& whole : pictures) {
        for (int trial = 0; trial < tests::trials(60); ++trial) {
            std::string other = whole.substr(0, 20'000);
            if (trial % 2 == 0)
                other.resize(tests::below(random, 700));
            else
                other[tests::below(random, 600)] = static_cast<char>(random());
            const auto decoded = decodePicture(std::as_bytes(std::span(other)), 1 << 22);
            if (decoded) {
                EXPECT_LE(decoded->rgba.size(), std::size_t{1} << 22U);
            }
        }
    }
}

} // namespace isofront::exchange::test
