// Based on: Khronos Group, "glTF 2.0 Specification", 2021: section 4.4 (GLB file format), 3.6
// (binary data storage: alignment, accessor bounds), 3.7.2 (meshes), 3.9 (materials).

#include "BlockWriter.h"
#include "MeshFormats.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace isofront::exchange {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::uint32_t kMagic = 0x46546C67;     // "glTF"
constexpr std::uint32_t kJsonChunk = 0x4E4F534A; // "JSON"
constexpr std::uint32_t kBinChunk = 0x004E4942;  // "BIN"
constexpr int kFloat = 5126;
constexpr int kUint8 = 5121;
constexpr int kUint16 = 5123;
constexpr int kUint32 = 5125;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;

/// 65535 itself restarts a primitive and so names no vertex.
constexpr std::uint64_t kMostShortVertices = 65535;

constexpr std::uint64_t aligned(std::uint64_t bytes)
{
    return (bytes + 3) & ~std::uint64_t{3};
}

std::uint64_t indexBytes(std::uint64_t vertices)
{
    return vertices <= kMostShortVertices ? 2 : 4;
}

glm::vec3 localPosition(const glm::dvec3& position, const glm::dvec3& translation)
{
    return glm::vec3(position - translation);
}

Json vectorJson(const glm::dvec3& v)
{
    return Json::array({v.x, v.y, v.z});
}

/// The part that the empty file has too.
Json headJson(const ExportOptions& options)
{
    Json head;
    head["asset"]["version"] = "2.0";
    head["asset"]["generator"] = options.generator;
    if (!options.settings.empty()) {
        Json& settings = head["asset"]["extras"]["settings"];
        for (const auto& [key, value] : options.settings)
            settings[key] = value;
    }
    head["scene"] = 0;
    head["scenes"] = Json::array({{{"name", options.name}}});
    return head;
}

void addMeshJson(Json& head, const MeshJob& job, const glm::dvec3& translation)
{
    const MeshView& mesh = job.mesh;
    const std::uint64_t vertices = mesh.vertexCount();
    const std::uint64_t vectorBytes = 12 * vertices;
    const std::uint64_t indices = 3 * std::uint64_t{mesh.triangleCount()};

    head["scenes"][0]["nodes"] = {0};
    Json node = {{"name", job.options.name}, {"mesh", 0}};
    if (translation != glm::dvec3(0))
        node["translation"] = vectorJson(translation);
    head["nodes"] = Json::array({node});
    head["materials"] = Json::array(
        {{{"name", "neutral"},
          {"pbrMetallicRoughness",
           {{"baseColorFactor", {0.72, 0.71, 0.68, 1.0}},
            {"metallicFactor", 0.0},
            {"roughnessFactor", 0.85}}},
          // A surface may end at the border of its data, where one looks at it from behind.
          {"doubleSided", true}}});

    Json views = Json::array();
    Json accessors = Json::array();
    std::uint64_t offset = 0;
    const auto add = [&](std::uint64_t bytes, int target, Json accessor) {
        accessor["bufferView"] = views.size();
        views.push_back(
            {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}, {"target", target}});
        offset += aligned(bytes);
        accessors.push_back(std::move(accessor));
        return accessors.size() - 1;
    };

    Json attributes;
    // Rounding keeps the order of numbers, so the bounds of the local floats are those of the mesh.
    attributes["POSITION"] =
        add(vectorBytes,
            kArrayBuffer,
            {{"componentType", kFloat},
             {"count", vertices},
             {"type", "VEC3"},
             {"min", vectorJson(glm::dvec3(localPosition(mesh.bounds().low, translation)))},
             {"max", vectorJson(glm::dvec3(localPosition(mesh.bounds().high, translation)))}});
    if (mesh.hasNormals())
        attributes["NORMAL"] =
            add(vectorBytes,
                kArrayBuffer,
                {{"componentType", kFloat}, {"count", vertices}, {"type", "VEC3"}});
    // glTF has no 32-bit integers for vertices, so a word goes as its bytes, the lowest first.
    if (mesh.hasAttributes())
        attributes["_ATTRIBUTE"] =
            add(4 * vertices,
                kArrayBuffer,
                {{"componentType", kUint8}, {"count", vertices}, {"type", "VEC4"}});
    const auto indexAccessor =
        add(indices * indexBytes(vertices),
            kElementArrayBuffer,
            {{"componentType", indexBytes(vertices) == 2 ? kUint16 : kUint32},
             {"count", indices},
             {"type", "SCALAR"}});

    head["meshes"] = Json::array(
        {{{"name", job.options.name},
          {"primitives",
           Json::array(
               {{{"attributes", attributes},
                 {"indices", indexAccessor},
                 {"material", 0},
                 {"mode", 4}}})}}});
    head["accessors"] = std::move(accessors);
    head["bufferViews"] = std::move(views);
    head["buffers"] = Json::array({{{"byteLength", offset}}});
}

/// @return the largest error of a coordinate [world]
double writeBinary(const MeshJob& job, const glm::dvec3& translation)
{
    const MeshView& mesh = job.mesh;
    BlockWriter out(job.file);
    double error = 0;
    for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex) {
        const glm::vec3 local = localPosition(mesh.position(vertex), translation);
        out.put(local);
        const glm::dvec3 off = glm::abs(translation + glm::dvec3(local) - mesh.position(vertex));
        error = std::max({error, off.x, off.y, off.z});
    }
    if (mesh.hasNormals())
        for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex)
            out.put(mesh.normal(vertex));
    if (mesh.hasAttributes())
        for (std::size_t vertex = 0; vertex < mesh.vertexCount(); ++vertex)
            out.put(mesh.attribute(vertex));
    const bool isShort = indexBytes(mesh.vertexCount()) == 2;
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle)
        for (int corner = 0; corner < 3; ++corner) {
            const std::uint32_t index = mesh.triangle(triangle)[corner];
            if (isShort)
                out.put(static_cast<std::uint16_t>(index));
            else
                out.put(index);
        }
    if (isShort && mesh.triangleCount() % 2 == 1)
        out.put(std::uint16_t{0});
    return error;
}

} // namespace

glm::dvec3 glbTranslation(const core::Box& bounds)
{
    const glm::dvec3 centre = 0.5 * bounds.low + 0.5 * bounds.high;
    const glm::dvec3 size = 0.5 * bounds.high - 0.5 * bounds.low;
    const double extent = std::max({size.x, size.y, size.z});
    const double furthest = std::max({std::abs(centre.x), std::abs(centre.y), std::abs(centre.z)});
    if (furthest == 0)
        return glm::dvec3(0);
    // Below 2^24 steps from zero a float holds every multiple of a step.
    int exponent = std::ilogb(furthest) - 22;
    if (extent > 0)
        exponent = std::max(exponent, std::ilogb(extent) - 3);
    const auto rounded = [exponent](double value) {
        return std::ldexp(std::nearbyint(std::ldexp(value, -exponent)), exponent);
    };
    return {rounded(centre.x), rounded(centre.y), rounded(centre.z)};
}

std::uint64_t
glbBinaryBytes(std::uint64_t vertices, std::uint64_t triangles, bool normals, bool attributes)
{
    const std::uint64_t vertexBytes = 12 + (normals ? 12U : 0U) + (attributes ? 4U : 0U);
    return vertices * vertexBytes + aligned(3 * triangles * indexBytes(vertices));
}

core::Result<void> writeGlb(const MeshJob& job)
{
    const MeshView& mesh = job.mesh;
    Json json = headJson(job.options);
    glm::dvec3 translation(0);
    std::uint64_t binaryBytes = 0;
    if (!mesh.isEmpty()) {
        constexpr auto kMost = static_cast<double>(std::numeric_limits<float>::max());
        const glm::dvec3 size = 0.5 * mesh.bounds().high - 0.5 * mesh.bounds().low;
        const glm::dvec3 furthest =
            glm::max(glm::abs(mesh.bounds().low), glm::abs(mesh.bounds().high));
        if (!(std::max({size.x, size.y, size.z}) < kMost / 4 &&
              std::max({furthest.x, furthest.y, furthest.z}) < kMost / 4))
            return core::failure(
                core::ErrorCode::badData,
                "its coordinates are too large for glTF, which stores floats; write .ply or .obj");
        translation = glbTranslation(mesh.bounds());
        binaryBytes = glbBinaryBytes(
            mesh.vertexCount(), mesh.triangleCount(), mesh.hasNormals(), mesh.hasAttributes());
        addMeshJson(json, job, translation);
    }

    std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace);
    text.resize(aligned(text.size()), ' ');
    const std::uint64_t bytes =
        12 + 8 + std::uint64_t{text.size()} + (binaryBytes > 0 ? 8 + binaryBytes : 0);
    if (bytes > std::numeric_limits<std::uint32_t>::max())
        return core::failure(
            core::ErrorCode::resourceLimit,
            "the mesh takes " + std::to_string(bytes) +
                " bytes, and a .glb file ends at 4 GiB; write .ply, or extract less detail");

    {
        BlockWriter out(job.file);
        out.put(kMagic);
        out.put(std::uint32_t{2});
        out.put(static_cast<std::uint32_t>(bytes));
        out.put(static_cast<std::uint32_t>(text.size()));
        out.put(kJsonChunk);
        out.put(std::string_view(text));
        if (binaryBytes > 0) {
            out.put(static_cast<std::uint32_t>(binaryBytes));
            out.put(kBinChunk);
        }
    }
    if (binaryBytes > 0)
        job.report.positionError = writeBinary(job, translation);
    return {};
}

} // namespace isofront::exchange
