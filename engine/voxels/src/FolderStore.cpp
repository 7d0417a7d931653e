#include "ChunkCodec.h"
#include "Durability.h"
#include "WriterLock.h"

#include <isofront/voxels/ChunkStore.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <fstream>
#include <tuple>

namespace isofront::voxels {

namespace {

constexpr const char* kModelFile = "model.json";
constexpr const char* kDirectoryFile = "directory";
constexpr std::string_view kExtension = ".chunk";
/// Larger files than any chunk's, all of whose voxels have colours and a look for each face, are
/// not read.
constexpr std::uintmax_t kMostBytes = std::uintmax_t{kChunkEdge} * kChunkEdge * kChunkEdge *
                                          (sizeof(Voxel) + sizeof(std::uint32_t) + sizeof(FaceSet) +
                                           kFaces * sizeof(FaceAttributes)) +
                                      1024;

core::Error unusable(const std::filesystem::path& path, const std::string& why)
{
    return {core::ErrorCode::inputOutput, path.string() + ": " + why};
}

/// Writes a file, which is durable when this returns. 0, or an error number.
int writeDurably(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0)
        return errno;
    int failed = 0;
    while (failed == 0 && !bytes.empty()) {
        const ::ssize_t count = ::write(file, bytes.data(), bytes.size());
        if (count >= 0)
            bytes = bytes.subspan(static_cast<std::size_t>(count));
        else if (errno != EINTR)
            failed = errno;
    }
    if (failed == 0 && ::fsync(file) != 0)
        failed = errno;
    if (::close(file) != 0 && failed == 0)
        failed = errno;
    return failed;
}

/// Writes a file whole: beside its place first.
std::optional<core::Error>
writeWhole(const std::filesystem::path& path, std::span<const std::byte> bytes)
{
    const std::filesystem::path part = path.string() + ".part";
    if (const int code = writeDurably(part, bytes); code != 0)
        return unusable(part, "can't be written: " + writeFailure(code));
    std::error_code failed;
    std::filesystem::rename(part, path, failed);
    if (failed)
        return unusable(path, "can't be given its name: " + failed.message());
    return std::nullopt;
}

core::Result<std::optional<std::vector<std::byte>>> readWhole(const std::filesystem::path& path)
{
    std::error_code failed;
    const auto size = std::filesystem::file_size(path, failed);
    if (failed == std::errc::no_such_file_or_directory)
        return std::optional<std::vector<std::byte>>();
    if (failed)
        return tl::unexpected(unusable(path, failed.message()));
    if (size > kMostBytes)
        return core::failure(
            core::ErrorCode::badData,
            path.string() + ": " + std::to_string(size) + " bytes are more than a chunk has");
    std::vector<std::byte> bytes(static_cast<std::size_t>(size));
    std::ifstream file(path, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size)))
        return tl::unexpected(unusable(path, "can't be read"));
    return std::optional(std::move(bytes));
}

/// Three numbers of "z-y-x", or nothing.
std::optional<std::array<std::uint32_t, 3>> numbersOf(std::string_view name)
{
    std::array<std::uint32_t, 3> numbers{};
    const char* at = name.data();
    const char* const end = at + name.size();
    for (std::size_t i = 0; i < 3; ++i) {
        if (i > 0 && (at == end || *at++ != '-'))
            return std::nullopt;
        const auto [next, error] = std::from_chars(at, end, numbers[i]);
        if (error != std::errc())
            return std::nullopt;
        at = next;
    }
    return at == end ? std::optional(numbers) : std::nullopt;
}

/// Whether all that a folder holds may be the beginning of a model.
bool isLeftOver(const std::filesystem::path& folder)
{
    const auto all = [](const std::filesystem::path& in, const auto& isOurs) {
        std::error_code failed;
        std::filesystem::directory_iterator entry(in, failed);
        for (; !failed && entry != std::filesystem::directory_iterator(); entry.increment(failed)) {
            std::error_code ignored;
            std::filesystem::path name = entry->path().filename();
            if (name.extension() == ".part")
                name = name.stem();
            if (!isOurs(*entry, name, entry->is_regular_file(ignored)))
                return false;
        }
        return !failed;
    };
    const auto isChunk = [](const auto&, const std::filesystem::path& name, bool isFile) {
        return isFile && name.extension() == kExtension && numbersOf(name.stem().string());
    };
    return all(folder, [&](const auto& entry, const std::filesystem::path& name, bool isFile) {
        if (isFile)
            return name == kModelFile || name == kDirectoryFile;
        const std::string level = name.string();
        return level.size() == 1 && level[0] >= '0' && level[0] <= '9' && !entry.is_symlink() &&
               all(entry.path(), isChunk);
    });
}

class FolderStore : public ChunkStore {
public:
    /// @param written  the name until it is done; empty for one that is
    /// @param lock     of what is written
    explicit FolderStore(
        std::filesystem::path path,
        std::filesystem::path written = {},
        std::optional<WriterLock> lock = std::nullopt)
        : _path(std::move(path)), _written(std::move(written)), _lock(std::move(lock))
    {
    }
    ~FolderStore() override
    {
        std::error_code ignored;
        if (!_written.empty())
            std::filesystem::remove_all(_written, ignored);
    }

    std::optional<core::Error> open()
    {
        const auto bytes = readWhole(_path / kModelFile);
        if (!bytes)
            return bytes.error();
        if (!*bytes)
            return core::Error{
                core::ErrorCode::badData,
                _path.string() + ": has no " + kModelFile +
                    ": it is not a model, or was not finished"};
        const auto model =
            decodedModel({reinterpret_cast<const char*>((*bytes)->data()), (*bytes)->size()});
        if (!model)
            return model.error().within((_path / kModelFile).string());
        _model = *model;
        return std::nullopt;
    }

    std::optional<core::Error> put(Chunk chunk) override
    {
        const std::filesystem::path file = fileOf(chunk.key);
        std::error_code failed;
        std::filesystem::create_directories(file.parent_path(), failed);
        if (failed)
            return unusable(file.parent_path(), "can't be made: " + failed.message());
        _directory.push_back(entryOf(chunk));
        return writeWhole(file, encoded(chunk));
    }
    std::optional<core::Error> finish(const StoredModel& model) override
    {
        if (auto failed = writeWhole(_written / kDirectoryFile, encoded(_directory)))
            return failed;
        const std::string text = encoded(model) + "\n";
        if (auto failed = writeWhole(_written / kModelFile, std::as_bytes(std::span(text))))
            return failed;
        // the names of all files, before the folder has its own
        std::vector<std::filesystem::path> folders{_written};
        std::error_code failed;
        std::filesystem::directory_iterator entry(_written, failed);
        for (; !failed && entry != std::filesystem::directory_iterator(); entry.increment(failed)) {
            std::error_code ignored;
            if (entry->is_directory(ignored))
                folders.push_back(entry->path());
        }
        if (failed)
            return unusable(_written, "can't be read: " + failed.message());
        for (const std::filesystem::path& folder : folders)
            if (const int code = makeDurable(folder); code != 0)
                return unusable(folder, "can't be written: " + writeFailure(code));
        std::filesystem::rename(_written, _path, failed);
        if (failed)
            return unusable(_path, "can't be given its name: " + failed.message());
        _written.clear();
        _model = model;
        if (const int code = makeDurable(folderOf(_path)); code != 0)
            return unusable(_path, "can't be given its name for good: " + writeFailure(code));
        return std::nullopt;
    }

    [[nodiscard]] const StoredModel& model() const override { return _model; }
    [[nodiscard]] std::string place() const override { return _path.string(); }

    [[nodiscard]] std::vector<ChunkKey> keys() const override
    {
        std::vector<ChunkKey> keys;
        for (std::uint32_t level = 0; level < _model.lattice.levels; ++level) {
            std::error_code failed;
            std::filesystem::directory_iterator entry(_path / std::to_string(level), failed);
            // a step of a range's would throw where a folder can't be read to its end
            for (; !failed && entry != std::filesystem::directory_iterator();
                 entry.increment(failed)) {
                if (entry->path().extension() != kExtension)
                    continue;
                if (const auto numbers = numbersOf(entry->path().stem().string()))
                    keys.push_back({level, (*numbers)[2], (*numbers)[1], (*numbers)[0]});
            }
        }
        std::ranges::sort(
            keys, {}, [](const ChunkKey& k) { return std::tuple(k.level, k.z, k.y, k.x); });
        return keys;
    }

    [[nodiscard]] core::Result<std::vector<ChunkEntry>> directory() const override
    {
        const auto bytes = readWhole(_path / kDirectoryFile);
        if (!bytes)
            return tl::unexpected(bytes.error());
        if (!*bytes)
            return core::failure(
                core::ErrorCode::badData,
                _path.string() + ": has no directory of its chunks; voxelise again");
        auto directory = decodedDirectory(**bytes);
        if (!directory)
            return tl::unexpected(directory.error().within(_path.string()));
        return directory;
    }

    [[nodiscard]] core::Result<std::optional<Chunk>> get(const ChunkKey& key) const override
    {
        const auto bytes = readWhole(fileOf(key));
        if (!bytes)
            return tl::unexpected(bytes.error());
        if (!*bytes)
            return std::optional<Chunk>();
        auto chunk = decodedChunk(**bytes, key);
        if (!chunk)
            return tl::unexpected(chunk.error().within(_path.string()));
        return std::optional(std::move(*chunk));
    }

private:
    [[nodiscard]] std::filesystem::path fileOf(const ChunkKey& key) const
    {
        std::string name =
            std::to_string(key.z) + "-" + std::to_string(key.y) + "-" + std::to_string(key.x);
        name += kExtension;
        return (_written.empty() ? _path : _written) / std::to_string(key.level) / name;
    }

    std::filesystem::path _path;
    std::filesystem::path _written;     ///< while it is not done
    std::optional<WriterLock> _lock;    ///< of what is written
    std::vector<ChunkEntry> _directory; ///< of what was put
    StoredModel _model;
};

} // namespace

core::Result<std::unique_ptr<ChunkStore>> createFolderStore(const std::filesystem::path& name)
{
    // "model/" is "model"
    const std::filesystem::path path = name.has_filename() ? name : name.parent_path();
    std::error_code failed;
    if (std::filesystem::exists(path, failed)) {
        if (!std::filesystem::is_directory(path, failed))
            return tl::unexpected(unusable(path, "is not a folder"));
        if (!std::filesystem::is_empty(path, failed))
            return core::failure(
                core::ErrorCode::usage, path.string() + ": is not empty; name a new folder");
    }
    const std::filesystem::path part = path.string() + ".part";
    auto lock = WriterLock::takeFolder(part, path);
    if (!lock)
        return tl::unexpected(lock.error());
    // nobody is writing it: what is there was left by a process that was killed, or is a user's own
    if (!isLeftOver(part))
        return tl::unexpected(unusable(
            part,
            "is there already, with files that no model has; move it or choose another name"));
    std::filesystem::directory_iterator entry(part, failed);
    for (; !failed && entry != std::filesystem::directory_iterator(); entry.increment(failed)) {
        std::filesystem::remove_all(entry->path(), failed);
        if (failed)
            break;
    }
    if (failed)
        return tl::unexpected(unusable(part, "can't be emptied: " + failed.message()));
    return std::make_unique<FolderStore>(path, part, std::move(*lock));
}

core::Result<std::unique_ptr<ChunkStore>> openFolderStore(const std::filesystem::path& path)
{
    auto store = std::make_unique<FolderStore>(path);
    if (auto failed = store->open())
        return tl::unexpected(*failed);
    return std::unique_ptr<ChunkStore>(std::move(store));
}

} // namespace isofront::voxels
