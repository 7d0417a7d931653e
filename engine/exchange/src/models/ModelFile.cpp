#include "ModelFormats.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/raster/FileBytes.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <memory>
#include <vector>

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

/// Gives memory back to the system from which a file was read, so that it doesn't count beside the
/// model that is made of it.
class PassedBytes {
public:
    explicit PassedBytes(std::vector<std::byte>& bytes) : _bytes(bytes) {}

    /// @param count  of the first bytes, which are not looked at again; what they are then is not
    ///               told
    void release(std::size_t count)
    {
        const std::size_t page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
        void* begin = _bytes.data() + _released;
        std::size_t space = std::min(count, _bytes.size()) - _released;
        // whole pages only: others may share the first
        if (std::align(page, page, begin, space) == nullptr)
            return;
        const std::size_t length = space / page * page;
        if (::madvise(begin, length, MADV_DONTNEED) == 0)
            _released =
                static_cast<std::size_t>(static_cast<std::byte*>(begin) - _bytes.data()) + length;
    }

private:
    std::vector<std::byte>& _bytes;
    std::size_t _released = 0;
};

} // namespace

bool isModelName(const std::filesystem::path& path)
{
    return readerOf(path) != nullptr;
}

core::Result<voxels::TriangleModel>
readModel(const std::filesystem::path& path, std::uint64_t mostBytes, OtherFiles otherFiles)
{
    const Reader reader = readerOf(path);
    if (reader == nullptr)
        return core::failure(
            core::ErrorCode::usage,
            path.string() +
                ": meshes are read from .glb, .gltf, .ply, .obj and .stl files, gzipped or not");
    if (auto readable = raster::checkReadable(path); !readable)
        return tl::unexpected(readable.error().within(path.string()));
    auto bytes = raster::readFileBytes(path, mostBytes, core::ErrorCode::resourceLimit);
    if (!bytes)
        return tl::unexpected(bytes.error().within(path.string()));
    PassedBytes passed(*bytes);
    auto model = reader(
        *bytes,
        {path.parent_path(),
         mostBytes,
         [&](std::size_t count) { passed.release(count); },
         otherFiles});
    if (!model)
        return tl::unexpected(model.error().within(path.string()));
    return model;
}

} // namespace isofront::exchange
