#include "ChunkCodec.h"

#include <nlohmann/json.hpp>
#include <zlib.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>

namespace isofront::voxels {

namespace {

static_assert(
    std::endian::native == std::endian::little, "chunks are stored as they lie in memory");

constexpr std::uint32_t kMagic = 0x43564649; // "IFVC"
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kMostVoxels = std::size_t{kChunkEdge} * kChunkEdge * kChunkEdge;

struct Header {
    std::uint32_t magic = kMagic;
    std::uint32_t version = kVersion;
    std::uint32_t level = 0;
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    std::uint32_t z = 0;
    std::uint32_t voxels = 0; ///< how many; the highest bits say what else there is
    std::uint32_t checksum = 0;
};
static_assert(sizeof(Header) == 32);
constexpr std::uint32_t kColoured = 1U << 31U;
constexpr std::uint32_t kFaced = 1U << 30U;

/// Comes before face sets and face attributes, if there are any.
struct FaceHeader {
    std::uint32_t sets = 0;
    std::uint32_t attributes = 0;
};
static_assert(sizeof(FaceHeader) == 8 && sizeof(FaceSet) == 8 && sizeof(FaceAttributes) == 8);

std::uint32_t checksumOf(Header header, std::span<const std::byte> rest)
{
    header.checksum = 0;
    const auto add = [](uLong sum, std::span<const std::byte> bytes) {
        return ::crc32_z(sum, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    };
    uLong sum = ::crc32_z(0, nullptr, 0);
    sum = add(sum, std::as_bytes(std::span(&header, 1)));
    return static_cast<std::uint32_t>(add(sum, rest));
}

core::Error damaged(const std::string& what)
{
    return {core::ErrorCode::badData, what};
}

} // namespace

std::vector<std::byte> encoded(const Chunk& chunk)
{
    const bool faced = !chunk.faceSets.empty();
    std::vector<std::byte> bytes(
        sizeof(Header) + chunk.bytes() + (faced ? sizeof(FaceHeader) : std::size_t{0}));
    std::size_t end = sizeof(Header);
    const auto add = [&](const auto& values) {
        const auto part = std::as_bytes(std::span(values));
        if (!part.empty())
            std::memcpy(bytes.data() + end, part.data(), part.size());
        end += part.size();
    };
    add(chunk.voxels);
    add(chunk.colours);
    if (faced) {
        add(std::array{FaceHeader{
            static_cast<std::uint32_t>(chunk.faceSets.size()),
            static_cast<std::uint32_t>(chunk.faceAttributes.size())}});
        add(chunk.faceSets);
        add(chunk.faceAttributes);
    }
    Header header;
    header.level = chunk.key.level;
    header.x = chunk.key.x;
    header.y = chunk.key.y;
    header.z = chunk.key.z;
    header.voxels = static_cast<std::uint32_t>(chunk.voxels.size()) |
                    (chunk.colours.empty() ? 0 : kColoured) | (faced ? kFaced : 0);
    header.checksum = checksumOf(header, std::span(bytes).subspan(sizeof(Header)));
    std::memcpy(bytes.data(), &header, sizeof(Header));
    return bytes;
}

namespace {

/// What is wrong in a chunk that was stored whole; nothing if it is in order.
const char* disorderOf(const Chunk& chunk)
{
    for (std::size_t i = 1; i < chunk.voxels.size(); ++i)
        if (chunk.voxels[i].order() <= chunk.voxels[i - 1].order())
            return "its voxels are not in order";
    if (!hasSoundFaces(chunk))
        return "its face sets are not in order, or name what is not there";
    return nullptr;
}

} // namespace

core::Result<Chunk> decodedChunk(std::span<const std::byte> bytes, const ChunkKey& key)
{
    const auto fail = [&](const std::string& what) -> core::Result<Chunk> {
        return tl::unexpected(damaged(nameOf(key) + " is damaged: " + what));
    };
    Header header;
    if (bytes.size() < sizeof(Header))
        return fail("it ends within its header");
    std::memcpy(&header, bytes.data(), sizeof(Header));
    if (header.magic != kMagic)
        return fail("it doesn't begin as a chunk");
    if (header.version != kVersion)
        return fail(
            "its version is " + std::to_string(header.version) + ", not " +
            std::to_string(kVersion));
    if (ChunkKey{header.level, header.x, header.y, header.z} != key)
        return fail("it is " + nameOf({header.level, header.x, header.y, header.z}));
    const std::size_t count = header.voxels & ~(kColoured | kFaced);
    const bool coloured = (header.voxels & kColoured) != 0;
    const bool faced = (header.voxels & kFaced) != 0;
    std::span<const std::byte> rest = bytes.subspan(sizeof(Header));
    const std::string size =
        "it has " + std::to_string(rest.size()) + " bytes for " + std::to_string(count) + " voxels";
    if (count == 0 || count > kMostVoxels)
        return fail(size);
    if (checksumOf(header, rest) != header.checksum)
        return fail("its checksum is wrong");

    Chunk chunk;
    chunk.key = key;
    const auto take = [&](auto& values, std::size_t length) {
        const std::size_t part = length * sizeof(values[0]);
        if (part > rest.size())
            return false;
        values.resize(length);
        if (part > 0)
            std::memcpy(values.data(), rest.data(), part);
        rest = rest.subspan(part);
        return true;
    };
    std::vector<FaceHeader> faces;
    if (!take(chunk.voxels, count) || (coloured && !take(chunk.colours, count)) ||
        (faced && (!take(faces, 1) || !take(chunk.faceSets, faces[0].sets) ||
                   !take(chunk.faceAttributes, faces[0].attributes))) ||
        !rest.empty())
        return fail(size);
    if (const char* wrong = disorderOf(chunk))
        return fail(wrong);
    return chunk;
}

namespace {

constexpr std::uint32_t kDirectoryMagic = 0x44564649; // "IFVD"
constexpr std::uint32_t kDirectoryVersion = 2;

struct DirectoryHeader {
    std::uint32_t magic = kDirectoryMagic;
    std::uint32_t version = kDirectoryVersion;
    std::uint32_t entries = 0;
    std::uint32_t checksum = 0;
};
static_assert(sizeof(DirectoryHeader) == 16);

struct StoredEntry {
    std::uint32_t level = 0;
    std::uint32_t x = 0;
    std::uint32_t y = 0;
    std::uint32_t z = 0;
    std::uint32_t voxels = 0; ///< how many; the highest bit says that there are colours
    std::uint32_t faceSets = 0;
    std::uint32_t faceAttributes = 0;
    std::uint32_t parents = 0;
    std::uint64_t bytes = 0;
    std::array<std::uint8_t, 3> low{};
    std::array<std::uint8_t, 3> high{};
    std::array<std::uint8_t, 2> unused{};
};
static_assert(sizeof(StoredEntry) == 48);

std::uint32_t checksumOf(std::span<const std::byte> bytes)
{
    return static_cast<std::uint32_t>(::crc32_z(
        ::crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

} // namespace

std::vector<std::byte> encoded(std::span<const ChunkEntry> directory)
{
    std::vector<std::byte> bytes(sizeof(DirectoryHeader) + directory.size() * sizeof(StoredEntry));
    std::byte* at = bytes.data() + sizeof(DirectoryHeader);
    for (const ChunkEntry& entry : directory) {
        const StoredEntry stored{
            entry.key.level,
            entry.key.x,
            entry.key.y,
            entry.key.z,
            entry.voxels | (entry.coloured ? kColoured : 0),
            entry.faceSets,
            entry.faceAttributes,
            entry.parents,
            entry.bytes,
            entry.low,
            entry.high,
            {}};
        std::memcpy(at, &stored, sizeof(StoredEntry));
        at += sizeof(StoredEntry);
    }
    DirectoryHeader header;
    header.entries = static_cast<std::uint32_t>(directory.size());
    header.checksum = checksumOf(std::span(bytes).subspan(sizeof(DirectoryHeader)));
    std::memcpy(bytes.data(), &header, sizeof(DirectoryHeader));
    return bytes;
}

core::Result<std::vector<ChunkEntry>> decodedDirectory(std::span<const std::byte> bytes)
{
    const auto fail = [](const std::string& what) -> core::Result<std::vector<ChunkEntry>> {
        return tl::unexpected(
            damaged("the directory of chunks is damaged: " + what + "; voxelise again"));
    };
    DirectoryHeader header;
    if (bytes.size() < sizeof(DirectoryHeader))
        return fail("it ends within its header");
    std::memcpy(&header, bytes.data(), sizeof(DirectoryHeader));
    if (header.magic != kDirectoryMagic)
        return fail("it doesn't begin as one");
    if (header.version != kDirectoryVersion)
        return fail(
            "its version is " + std::to_string(header.version) + ", not " +
            std::to_string(kDirectoryVersion));
    const std::span<const std::byte> body = bytes.subspan(sizeof(DirectoryHeader));
    if (body.size() != std::size_t{header.entries} * sizeof(StoredEntry))
        return fail(
            "it has " + std::to_string(body.size()) + " bytes for " +
            std::to_string(header.entries) + " chunks");
    if (checksumOf(body) != header.checksum)
        return fail("its checksum is wrong");
    std::vector<ChunkEntry> directory;
    directory.reserve(header.entries);
    for (std::size_t i = 0; i < header.entries; ++i) {
        StoredEntry stored;
        std::memcpy(&stored, body.data() + i * sizeof(StoredEntry), sizeof(StoredEntry));
        directory.push_back(
            {{stored.level, stored.x, stored.y, stored.z},
             stored.voxels & ~kColoured,
             (stored.voxels & kColoured) != 0,
             stored.faceSets,
             stored.faceAttributes,
             stored.bytes,
             stored.low,
             stored.high,
             stored.parents});
    }
    return directory;
}

namespace {

constexpr const char* kModelFormat = "isofront-voxels";
/// Of models without a source and a field. One that has a source is of the next version, and one
/// that has a field, with or without a source, of the one after that; they are the same but for
/// that. So programs that don't know of either read all that they can.
constexpr std::uint32_t kModelVersion = 3;
constexpr std::uint32_t kSourceVersion = 4;
constexpr std::uint32_t kFieldVersion = 5;

using Json = nlohmann::ordered_json;

std::string textOf(const Json& json)
{
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

/// What there is to know of a model, without the checksum.
Json descriptionOf(const StoredModel& model)
{
    Json json;
    json["format"] = kModelFormat;
    json["version"] = model.field ? kFieldVersion : model.source ? kSourceVersion : kModelVersion;
    json["name"] = model.name;
    json["origin"] = {model.lattice.origin.x, model.lattice.origin.y, model.lattice.origin.z};
    json["voxel_edge"] = model.lattice.edge;
    json["resolution"] = model.lattice.resolution;
    json["levels"] = model.lattice.levels;
    json["voxels"] = model.voxels;
    json["all_voxels"] = model.allVoxels;
    json["chunks"] = model.chunks;
    json["coloured"] = model.coloured;
    json["separability"] = model.separability == Separability::six ? "six" : "conservative";
    if (model.source)
        json["source"] = {
            {"path", model.source->path},
            {"bytes", model.source->bytes},
            {"checksum", model.source->checksum}};
    if (model.field)
        json["field"] = {
            {"source", model.field->source},
            {"isovalue", model.field->isovalue},
            {"filter", model.field->filter},
            {"closed", model.field->closed},
            {"checksum", model.field->checksum}};
    return json;
}

std::uint32_t checksumOf(const Json& description)
{
    const std::string text = textOf(description);
    return checksumOf(std::as_bytes(std::span(text)));
}

/// A whole number that fits, or nothing. JSON's own conversions would cut others to fit.
template <typename T>
std::optional<T> wholeNumber(const Json& json)
{
    if (!json.is_number_unsigned() || json.get<std::uint64_t>() > std::numeric_limits<T>::max())
        return std::nullopt;
    return static_cast<T>(json.get<std::uint64_t>());
}

bool makesSense(const VoxelLattice& lattice)
{
    if (lattice.resolution < 1 || lattice.resolution > kMaxResolution ||
        lattice.levels != levelsFor(lattice.resolution) || !(lattice.edge > 0))
        return false;
    const glm::dvec3 high = lattice.origin + std::ldexp(lattice.edge * kChunkEdge, 9);
    return std::isfinite(high.x) && std::isfinite(high.y) && std::isfinite(high.z);
}

} // namespace

std::string encoded(const StoredModel& model)
{
    Json json = descriptionOf(model);
    const std::uint32_t checksum = checksumOf(json);
    json["checksum"] = checksum;
    return textOf(json);
}

core::Result<StoredModel> decodedModel(std::string_view text)
{
    const auto fail = [](const std::string& what) -> core::Result<StoredModel> {
        return tl::unexpected(
            damaged("the description of the model is damaged: " + what + "; voxelise again"));
    };
    const auto json = Json::parse(text, nullptr, false);
    if (!json.is_object())
        return fail("it is not one");
    try {
        if (json.at("format") != kModelFormat)
            return fail("it is not one");
        const auto version = wholeNumber<std::uint32_t>(json.at("version"));
        if (version && (*version < kModelVersion || *version > kFieldVersion))
            return tl::unexpected(damaged(
                "its version is " + std::to_string(*version) + "; this program reads versions " +
                std::to_string(kModelVersion) + " to " + std::to_string(kFieldVersion) +
                (*version < kModelVersion ? ": voxelise again" : ": use a newer one")));
        StoredModel model;
        model.name = json.at("name").get<std::string>();
        const Json& origin = json.at("origin");
        if (!origin.is_array() || origin.size() != 3)
            return fail("its origin is not three numbers");
        model.lattice.origin = {
            origin[0].get<double>(), origin[1].get<double>(), origin[2].get<double>()};
        model.lattice.edge = json.at("voxel_edge").get<double>();
        const auto resolution = wholeNumber<std::uint32_t>(json.at("resolution"));
        const auto levels = wholeNumber<std::uint32_t>(json.at("levels"));
        const auto voxels = wholeNumber<std::uint64_t>(json.at("voxels"));
        const auto allVoxels = wholeNumber<std::uint64_t>(json.at("all_voxels"));
        const auto chunks = wholeNumber<std::uint64_t>(json.at("chunks"));
        const auto checksum = wholeNumber<std::uint32_t>(json.at("checksum"));
        if (!version || !resolution || !levels || !voxels || !allVoxels || !chunks || !checksum)
            return fail("a number of it is not a whole one, or too large");
        model.lattice.resolution = *resolution;
        model.lattice.levels = *levels;
        model.voxels = *voxels;
        model.allVoxels = *allVoxels;
        model.chunks = *chunks;
        model.coloured = json.at("coloured").get<bool>();
        const auto separability = json.at("separability").get<std::string>();
        if (separability != "six" && separability != "conservative")
            return fail("its voxels are separated in an unknown way");
        model.separability = separability == "six" ? Separability::six : Separability::conservative;
        if (*version == kFieldVersion) {
            const Json& field = json.at("field");
            const auto sum = wholeNumber<std::uint64_t>(field.at("checksum"));
            if (!sum)
                return fail("a number of it is not a whole one, or too large");
            model.field = ModelField{
                field.at("source").get<std::string>(),
                field.at("isovalue").get<double>(),
                field.at("filter").get<double>(),
                field.at("closed").get<bool>(),
                *sum};
        }
        if (*version == kSourceVersion || (*version == kFieldVersion && json.contains("source"))) {
            const Json& source = json.at("source");
            const auto bytes = wholeNumber<std::uint64_t>(source.at("bytes"));
            const auto sum = wholeNumber<std::uint32_t>(source.at("checksum"));
            if (!bytes || !sum)
                return fail("a number of it is not a whole one, or too large");
            model.source = ModelSource{source.at("path").get<std::string>(), *bytes, *sum};
        }
        if (!makesSense(model.lattice))
            return fail("its lattice makes no sense");
        // of what was understood: so nothing was read in another way than it was meant
        if (checksumOf(descriptionOf(model)) != *checksum)
            return fail("its checksum is wrong");
        return model;
    } catch (const Json::exception&) {
        return fail("a part is missing, or of another kind");
    }
}

} // namespace isofront::voxels
