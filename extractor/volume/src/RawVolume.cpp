#include "RawVolume.h"

#include "FileHeader.h"
#include "RawNumbers.h"
#include "TextHeader.h"

#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <fstream>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <system_error>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;
using Json = nlohmann::json;

/// What a raw file doesn't say about itself.
struct Layout {
    std::array<std::int64_t, 3> dimensions{0, 0, 0};
    raster::SampleType type = raster::SampleType::uint8;
    bool bigEndian = false;
    std::uint64_t offset = 0; ///< [bytes] of the first voxel
    core::Affine worldFromIndex;
    bool hasSpacing = false;
};

constexpr std::string_view kExample = "as in 256x256x128,uint16,little,0";
constexpr std::string_view kTypes =
    "int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32 and float64";

std::vector<std::string> parts(const std::string& text, char separator)
{
    std::vector<std::string> result(1);
    for (const char c : text) {
        if (c == separator)
            result.emplace_back();
        else
            result.back() += c;
    }
    return result;
}

/// "256x256x128,uint16,little,0"; byte order and offset may be left out.
core::Result<Layout> layoutFromText(const std::string& text)
{
    const auto refused = [&](const std::string& why) {
        return failure(
            ErrorCode::usage,
            "--raw '" + text + "': " + why + "; give size, type, byte order and offset, " +
                std::string(kExample));
    };
    Layout layout;
    const std::vector<std::string> fields = parts(text, ',');
    const std::vector<std::string> sizes = parts(fields[0], 'x');
    if (sizes.size() != 3)
        return refused("it begins with three sizes");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto size = integerFrom(sizes[axis]);
        if (!size || *size < 1)
            return refused("'" + sizes[axis] + "' is no number of voxels");
        layout.dimensions[axis] = *size;
    }
    const auto type =
        fields.size() > 1 ? raster::sampleTypeNamed(trimmed(lowered(fields[1]))) : std::nullopt;
    if (!type)
        return refused("the second field is one of " + std::string(kTypes));
    layout.type = *type;
    bool hasOrder = raster::bytesOf(*type) == 1;
    for (std::size_t i = 2; i < fields.size(); ++i) {
        const std::string field(trimmed(lowered(fields[i])));
        const auto offset = integerFrom(field);
        if (i == 2 && (field == "little" || field == "big")) {
            layout.bigEndian = field == "big";
            hasOrder = true;
        } else if (i + 1 == fields.size() && offset && *offset >= 0) {
            layout.offset = static_cast<std::uint64_t>(*offset);
        } else {
            return refused("'" + fields[i] + "' is neither little or big nor an offset in bytes");
        }
    }
    if (!hasOrder)
        return refused("the byte order of " + fields[1] + " is missing");
    return layout;
}

/// Three finite numbers.
std::optional<glm::dvec3> vectorFrom(const Json& json)
{
    if (!json.is_array() || json.size() != 3)
        return std::nullopt;
    glm::dvec3 vector(0.0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!json[axis].is_number() || !std::isfinite(json[axis].get<double>()))
            return std::nullopt;
        vector[axis] = json[axis].get<double>();
    }
    return vector;
}

core::Result<Layout> layoutFromJson(const std::filesystem::path& path)
{
    const auto refused = [&](const std::string& why) {
        return failure(ErrorCode::badData, "its description " + path.string() + " " + why);
    };
    constexpr std::size_t kMostBytes = 65536;
    std::string text(kMostBytes, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(file.gcount()));
    const Json json = Json::parse(text, nullptr, false);
    if (!json.is_object())
        return refused("is no JSON object; docs/cli.md shows one");
    static const std::set<std::string> kKnown{
        "dimensions", "type", "byteOrder", "offset", "spacing", "origin", "directions"};
    for (const auto& [key, value] : json.items())
        if (!kKnown.contains(key))
            return refused(
                "has a key '" + key +
                "'; known are dimensions, type, byteOrder, offset, spacing, origin and directions");

    Layout layout;
    const Json sizes = json.value("dimensions", Json());
    if (!sizes.is_array() || sizes.size() != 3)
        return refused("needs \"dimensions\": [x, y, z]");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!sizes[axis].is_number_unsigned() ||
            sizes[axis].get<std::uint64_t>() > std::uint64_t{INT64_MAX})
            return refused("has dimensions that are no numbers of voxels");
        layout.dimensions[axis] = sizes[axis].get<std::int64_t>();
    }
    const Json name = json.value("type", Json());
    const auto type =
        name.is_string() ? raster::sampleTypeNamed(lowered(name.get<std::string>())) : std::nullopt;
    if (!type)
        return refused("needs \"type\": one of " + std::string(kTypes));
    layout.type = *type;
    const Json order = json.value("byteOrder", Json());
    if (order == "big" || order == "little")
        layout.bigEndian = order == "big";
    else if (!order.is_null() || raster::bytesOf(*type) > 1)
        return refused("needs \"byteOrder\": \"little\" or \"big\"");
    const Json offset = json.value("offset", Json(0U));
    if (!offset.is_number_unsigned() || offset.get<std::uint64_t>() > std::uint64_t{INT64_MAX})
        return refused("has an offset that is no number of bytes");
    layout.offset = offset.get<std::uint64_t>();

    glm::dvec3 spacing(1.0);
    if (json.contains("spacing")) {
        const auto read = vectorFrom(json["spacing"]);
        if (!read || !(read->x > 0 && read->y > 0 && read->z > 0))
            return refused("has a spacing that is not three numbers above 0");
        spacing = *read;
        layout.hasSpacing = true;
    }
    if (json.contains("origin")) {
        const auto read = vectorFrom(json["origin"]);
        if (!read)
            return refused("has an origin that is not three numbers");
        layout.worldFromIndex.translation = *read;
    }
    glm::dmat3 directions(1.0);
    if (json.contains("directions")) {
        const Json& axes = json["directions"];
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto read =
                axes.is_array() && axes.size() == 3 ? vectorFrom(axes[axis]) : std::nullopt;
            if (!read || !(glm::length(*read) > 0))
                return refused("has directions that are not one vector for each axis");
            directions[axis] = glm::normalize(*read);
        }
    }
    for (std::size_t axis = 0; axis < 3; ++axis)
        layout.worldFromIndex.linear[axis] = spacing[axis] * directions[axis];
    return layout;
}

core::Result<Layout> layoutOf(const std::filesystem::path& path, const LoadOptions& options)
{
    if (!options.rawLayout.empty())
        return layoutFromText(options.rawLayout);
    std::error_code ignored;
    const std::filesystem::path beside = path.string() + ".json";
    if (std::filesystem::is_regular_file(beside, ignored))
        return layoutFromJson(beside);
    const std::filesystem::path instead = std::filesystem::path(path).replace_extension(".json");
    if (std::filesystem::is_regular_file(instead, ignored))
        return layoutFromJson(instead);
    return failure(
        ErrorCode::usage,
        "a raw file doesn't say what is in it; give --raw SIZE,TYPE,ORDER[,OFFSET], " +
            std::string(kExample) + ", or describe it in " + beside.filename().string());
}

bool isGzipped(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    return file.get() == 0x1f && file.get() == 0x8b;
}

} // namespace

core::Result<DenseVoxels>
readRawVolume(const std::filesystem::path& path, const LoadOptions& options)
{
    const auto layout = layoutOf(path, options);
    if (!layout)
        return tl::unexpected(layout.error());
    FileHeader header;
    header.dimensions = layout->dimensions;
    header.voxelBytes = raster::bytesOf(layout->type);
    header.dataFile = path;
    if (isGzipped(path)) {
        header.encoding = FileHeader::Encoding::deflate;
        header.unpackedOffset = layout->offset;
    } else {
        header.dataOffset = layout->offset;
    }
    if (const auto checked = checkHeader(header, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());

    DenseVoxels dense;
    if (header.encoding == FileHeader::Encoding::raw) {
        // checkHeader has seen that it has at least as many.
        std::error_code ignored;
        const std::uint64_t bytes = std::filesystem::file_size(path, ignored);
        const std::uint64_t end = layout->offset + header.dataBytes();
        if (!ignored && bytes > end)
            dense.notes.push_back(
                "The description covers " + std::to_string(header.dataBytes()) + " of the file's " +
                std::to_string(bytes) + " bytes; the last " + std::to_string(bytes - end) +
                " are not used, so size, type or offset may be wrong.");
    }
    dense.dimensions = glm::ivec3(header.dimensions[0], header.dimensions[1], header.dimensions[2]);
    dense.worldFromIndex = layout->worldFromIndex;
    if (!layout->hasSpacing && !options.voxelSize)
        dense.notes.push_back(
            "The size of a voxel is not given and taken for 1 (--voxel-size tells otherwise).");
    auto voxels = readRawNumbers(header, layout->type, layout->bigEndian, dense.notes);
    if (!voxels)
        return tl::unexpected(voxels.error());
    dense.voxels = std::move(*voxels);
    return dense;
}

} // namespace isofront::volume
