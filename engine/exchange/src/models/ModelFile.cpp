#include "ModelFormats.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/raster/FileBytes.h>

#include <algorithm>
#include <cctype>

namespace isofront::exchange {

namespace {

/// The extension in small letters, that of the packed file if it is gzipped.
std::string formatOf(std::filesystem::path path)
{
    const auto small = [](std::string text) {
        std::ranges::transform(
            text, text.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        return text;
    };
    if (small(path.extension().string()) == ".gz")
        path = path.stem();
    return small(path.extension().string());
}

using Reader =
    core::Result<voxels::TriangleModel> (*)(std::span<const std::byte>, const ModelContext&);

/// What reads a format; null if nothing does.
Reader readerOf(const std::filesystem::path& path)
{
    const std::string format = formatOf(path);
    if (format == ".glb" || format == ".gltf")
        return readGltf;
    return format == ".ply"   ? readPly
           : format == ".stl" ? readStl
           : format == ".obj" ? readObj
                              : nullptr;
}

} // namespace

bool isModelName(const std::filesystem::path& path)
{
    return readerOf(path) != nullptr;
}

core::Result<voxels::TriangleModel>
readModel(const std::filesystem::path& path, std::uint64_t mostBytes)
{
    const Reader reader = readerOf(path);
    if (reader == nullptr)
        return core::failure(
            core::ErrorCode::usage,
            path.string() +
                ": meshes are read from .glb, .gltf, .ply, .obj and .stl files, gzipped or not");
    if (auto readable = raster::checkReadable(path); !readable)
        return tl::unexpected(readable.error().within(path.string()));
    const auto bytes = raster::readFileBytes(path, mostBytes, core::ErrorCode::resourceLimit);
    if (!bytes)
        return tl::unexpected(bytes.error().within(path.string()));
    auto model = reader(*bytes, {path.parent_path(), mostBytes});
    if (!model)
        return tl::unexpected(model.error().within(path.string()));
    return model;
}

} // namespace isofront::exchange
