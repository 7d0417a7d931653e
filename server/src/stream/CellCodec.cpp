#include "CellCodec.h"

#include "Bytes.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Hash.h>

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <string>

namespace isofront::server {
namespace {

constexpr std::uint8_t kHasAttributes = 1;

/// What the vertex codec sees.
struct WireVertex {
    std::array<std::uint16_t, 3> position{};
    std::array<std::int8_t, 2> normal{};
};
static_assert(sizeof(WireVertex) == 8);

/// Rounded to nearest, halves away from zero: in integers, so that it is the same everywhere.
std::int8_t narrowed(std::int16_t wide)
{
    const int size = (2 * std::abs(int{wide}) * 127 + 32767) / (2 * 32767);
    return static_cast<std::int8_t>(wide < 0 ? -size : size);
}

std::int16_t widened(std::int8_t narrow)
{
    const int size = (2 * std::abs(int{narrow}) * 32767 + 127) / (2 * 127);
    return static_cast<std::int16_t>(std::clamp(narrow < 0 ? -size : size, -32767, 32767));
}

template <typename T>
std::vector<std::byte> encodedVertices(const std::vector<T>& vertices)
{
    std::vector<std::byte> bytes(meshopt_encodeVertexBufferBound(vertices.size(), sizeof(T)));
    bytes.resize(meshopt_encodeVertexBuffer(
        reinterpret_cast<unsigned char*>(bytes.data()),
        bytes.size(),
        vertices.data(),
        vertices.size(),
        sizeof(T)));
    return bytes;
}

template <typename T>
bool decodeVertices(std::span<const std::byte> bytes, std::vector<T>& vertices)
{
    return meshopt_decodeVertexBuffer(
               vertices.data(),
               vertices.size(),
               sizeof(T),
               reinterpret_cast<const unsigned char*>(bytes.data()),
               bytes.size()) == 0;
}

tl::unexpected<core::Error> notACell(const std::string& why)
{
    return core::failure(core::ErrorCode::badData, "cell: " + why + ": ask for it again");
}

/// Versions are settings of the whole process: once, before anything is encoded.
void chooseVersions()
{
    static const bool isDone = [] {
        meshopt_encodeIndexVersion(1);
        meshopt_encodeVertexVersion(0);
        return true;
    }();
    static_cast<void>(isDone);
}

} // namespace

std::uint64_t hashOf(std::span<const std::byte> bytes)
{
    std::uint64_t hash = bytes.size();
    while (!bytes.empty()) {
        const std::size_t count = std::min(bytes.size(), sizeof(std::uint64_t));
        std::uint64_t word = 0;
        std::memcpy(&word, bytes.data(), count);
        hash = core::hashCombined(hash, word);
        bytes = bytes.subspan(count);
    }
    return hash;
}

CellPayload encodeCell(const extractor::CellMesh& mesh)
{
    ISOFRONT_ASSERT(!mesh.indices.empty(), "cells without triangles are not sent");
    chooseVersions();
    const std::size_t vertexCount = mesh.vertices.size();
    std::vector<unsigned int> indices(mesh.indices.begin(), mesh.indices.end());
    meshopt_optimizeVertexCacheStrip(indices.data(), indices.data(), indices.size(), vertexCount);
    std::vector<unsigned int> places(vertexCount);
    const std::size_t used = meshopt_optimizeVertexFetchRemap(
        places.data(), indices.data(), indices.size(), vertexCount);
    meshopt_remapIndexBuffer(indices.data(), indices.data(), indices.size(), places.data());

    std::vector<WireVertex> vertices(used);
    std::vector<std::uint32_t> attributes(mesh.attributes.empty() ? 0 : used);
    for (std::size_t i = 0; i < vertexCount; ++i) {
        if (places[i] == std::numeric_limits<unsigned int>::max())
            continue; // of no triangle
        const extractor::CellVertex& vertex = mesh.vertices[i];
        vertices[places[i]] = {
            vertex.position, {narrowed(vertex.normal[0]), narrowed(vertex.normal[1])}};
        if (!attributes.empty())
            attributes[places[i]] = mesh.attributes[i];
    }

    std::vector<unsigned char> encoded(
        meshopt_encodeIndexBufferBound(indices.size(), vertices.size()));
    encoded.resize(
        meshopt_encodeIndexBuffer(encoded.data(), encoded.size(), indices.data(), indices.size()));
    const std::vector<std::byte> encodedShape = encodedVertices(vertices);

    ByteWriter bytes;
    bytes.put(mesh.low.x).put(mesh.low.y).put(mesh.low.z);
    bytes.put(mesh.exponent).put(attributes.empty() ? std::uint8_t{0} : kHasAttributes);
    bytes.put(static_cast<std::uint16_t>(vertices.size()));
    bytes.put(static_cast<std::uint32_t>(encoded.size()));
    bytes.put(static_cast<std::uint32_t>(mesh.triangleCount()));
    bytes.put(std::as_bytes(std::span(encoded)));
    if (attributes.empty()) {
        bytes.put(encodedShape);
    } else {
        bytes.put(static_cast<std::uint32_t>(encodedShape.size()));
        bytes.put(encodedShape).put(encodedVertices(attributes));
    }
    CellPayload payload;
    payload.bytes = bytes.take();
    payload.hash = hashOf(payload.bytes);
    return payload;
}

core::Result<extractor::CellMesh> decodeCell(std::span<const std::byte> bytes)
{
    ByteReader reader(bytes);
    extractor::CellMesh mesh;
    mesh.low.x = reader.get<std::uint32_t>();
    mesh.low.y = reader.get<std::uint32_t>();
    mesh.low.z = reader.get<std::uint32_t>();
    mesh.exponent = reader.get<std::uint8_t>();
    const auto flags = reader.get<std::uint8_t>();
    const std::size_t vertexCount = reader.get<std::uint16_t>();
    const std::size_t indexBytes = reader.get<std::uint32_t>();
    const std::size_t triangleCount = reader.get<std::uint32_t>();
    const std::span<const std::byte> encodedIndices = reader.get(indexBytes);
    if (!reader.isWhole())
        return notACell("it ends too early");
    // the codec takes at least a byte for a triangle
    if (triangleCount == 0 || triangleCount > indexBytes || vertexCount == 0 || mesh.exponent < 1 ||
        mesh.exponent > 32 || flags > kHasAttributes)
        return notACell("its header makes no sense");
    const std::size_t shapeBytes =
        flags == kHasAttributes ? reader.get<std::uint32_t>() : reader.left();
    const std::span<const std::byte> encodedShape = reader.get(shapeBytes);
    if (!reader.isWhole())
        return notACell("it ends too early");

    mesh.indices.resize(3 * triangleCount);
    if (meshopt_decodeIndexBuffer(
            mesh.indices.data(),
            mesh.indices.size(),
            sizeof(std::uint16_t),
            reinterpret_cast<const unsigned char*>(encodedIndices.data()),
            encodedIndices.size()) != 0)
        return notACell("its triangles can't be decoded");
    if (*std::ranges::max_element(mesh.indices) >= vertexCount)
        return notACell("a triangle names a vertex that isn't there");
    std::vector<WireVertex> vertices(vertexCount);
    if (!decodeVertices(encodedShape, vertices))
        return notACell("its vertices can't be decoded");
    for (const WireVertex& vertex : vertices)
        mesh.vertices.push_back(
            {vertex.position, 0, {widened(vertex.normal[0]), widened(vertex.normal[1])}});
    if (flags == kHasAttributes) {
        mesh.attributes.resize(vertexCount);
        if (!decodeVertices(reader.get(reader.left()), mesh.attributes))
            return notACell("its attributes can't be decoded");
    }
    return mesh;
}

} // namespace isofront::server
