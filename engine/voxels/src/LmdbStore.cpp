#include "ChunkCodec.h"
#include "Durability.h"
#include "LmdbCheck.h"
#include "WriterLock.h"

#include <isofront/voxels/ChunkStore.h>

#include <lmdb.h>

#include <array>
#include <mutex>
#include <utility>

namespace isofront::voxels {

namespace {

/// Address space, not memory or disk: the file only ever has what was written. Much more than the
/// finest models take; with a tebibyte, ThreadSanitizer's programs found no room for it.
constexpr std::size_t kMapSize = std::size_t{1} << 38U;
/// What is put is committed whenever so much has come together [bytes].
constexpr std::size_t kCommitEvery = std::size_t{32} << 20U;
constexpr mdb_mode_t kMode = 0644;

/// A chunk's name in the file: sorts by level, then z, y and x.
using KeyBytes = std::array<unsigned char, 14>;

KeyBytes bytesOf(const ChunkKey& key)
{
    KeyBytes bytes{'c', static_cast<unsigned char>(key.level)};
    std::size_t at = 2;
    for (const std::uint32_t number : {key.z, key.y, key.x})
        for (unsigned shift = 32; shift > 0; shift -= 8)
            bytes[at++] = static_cast<unsigned char>(number >> (shift - 8) & 0xffU);
    return bytes;
}

ChunkKey keyOf(const unsigned char* bytes)
{
    const auto number = [&](std::size_t at) {
        std::uint32_t value = 0;
        for (std::size_t i = 0; i < 4; ++i)
            value = value << 8U | bytes[at + i];
        return value;
    };
    return {bytes[1], number(10), number(6), number(2)};
}

constexpr std::string_view kModelKey = "model";
constexpr std::string_view kDirectoryKey = "directory";

MDB_val valueOf(std::span<const std::byte> bytes)
{
    // LMDB's interface knows no constants; it only reads these
    return {bytes.size(), const_cast<std::byte*>(bytes.data())};
}

/// What a code of LMDB says; those that are positive are error numbers.
std::string reasonOf(int code)
{
    return code > 0 ? writeFailure(code) : ::mdb_strerror(code);
}

/// An open LMDB file.
class Environment {
public:
    static core::Result<Environment> open(const std::filesystem::path& path, bool forWriting)
    {
        // LMDB itself would follow whatever a damaged file says
        if (!forWriting)
            if (auto damage = lmdbDamage(path))
                return tl::unexpected(std::move(*damage));
        Environment environment;
        const auto fail = [&](int code) {
            return core::failure(
                code == MDB_INVALID || code == MDB_VERSION_MISMATCH || code == MDB_CORRUPTED
                    ? core::ErrorCode::badData
                    : core::ErrorCode::inputOutput,
                path.string() + (forWriting ? ": can't be made: " : ": can't be opened: ") +
                    (code == MDB_INVALID ? "it is not a voxel model" : reasonOf(code)));
        };
        if (const int code = ::mdb_env_create(&environment._handle); code != 0)
            return fail(code);
        ::mdb_env_set_mapsize(environment._handle, kMapSize);
        // readers of a file that is done never meet a writer
        const unsigned flags =
            MDB_NOSUBDIR | (forWriting ? 0U : MDB_RDONLY | MDB_NOLOCK) | MDB_NOTLS | MDB_NORDAHEAD;
        if (const int code = ::mdb_env_open(environment._handle, path.c_str(), flags, kMode);
            code != 0)
            return fail(code);
        MDB_txn* transaction = nullptr;
        int code = ::mdb_txn_begin(
            environment._handle, nullptr, forWriting ? 0 : MDB_RDONLY, &transaction);
        if (code == 0)
            code = ::mdb_dbi_open(transaction, nullptr, 0, &environment._table);
        if (transaction != nullptr)
            code = code == 0 ? ::mdb_txn_commit(transaction) : (::mdb_txn_abort(transaction), code);
        if (code != 0)
            return fail(code);
        return environment;
    }

    Environment(Environment&& other) noexcept
        : _handle(std::exchange(other._handle, nullptr)), _table(other._table)
    {
    }
    Environment& operator=(Environment&&) = delete;
    Environment(const Environment&) = delete;
    Environment& operator=(const Environment&) = delete;
    ~Environment()
    {
        if (_handle != nullptr)
            ::mdb_env_close(_handle);
    }

    [[nodiscard]] MDB_env* handle() const { return _handle; }
    [[nodiscard]] MDB_dbi table() const { return _table; }

private:
    Environment() = default;
    MDB_env* _handle = nullptr;
    MDB_dbi _table = 0;
};

/// A transaction that is given up unless it is committed.
class Transaction {
public:
    Transaction() = default;
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    ~Transaction()
    {
        if (_handle != nullptr)
            ::mdb_txn_abort(_handle);
    }
    int begin(const Environment& environment, unsigned flags)
    {
        return ::mdb_txn_begin(environment.handle(), nullptr, flags, &_handle);
    }
    int commit() { return ::mdb_txn_commit(std::exchange(_handle, nullptr)); }
    [[nodiscard]] MDB_txn* handle() const { return _handle; }

private:
    MDB_txn* _handle = nullptr;
};

class LmdbStore : public ChunkStore {
public:
    LmdbStore(
        std::filesystem::path path,
        std::filesystem::path written,
        std::optional<WriterLock> lock,
        Environment environment)
        : _path(std::move(path)), _written(std::move(written)), _lock(std::move(lock)),
          _environment(std::move(environment))
    {
    }
    ~LmdbStore() override
    {
        if (!_isFinished && !_written.empty()) {
            std::error_code ignored;
            std::filesystem::remove(lockOf(_written), ignored);
            std::filesystem::remove(_written, ignored);
        }
    }

    core::Result<bool> readModel()
    {
        const auto bytes = read(std::as_bytes(std::span(kModelKey)));
        if (!bytes)
            return tl::unexpected(bytes.error());
        if (!*bytes)
            return core::failure(
                core::ErrorCode::badData,
                _path.string() + ": the model was not finished; voxelise it again");
        auto model =
            decodedModel({reinterpret_cast<const char*>((*bytes)->data()), (*bytes)->size()});
        if (!model)
            return tl::unexpected(model.error().within(_path.string()));
        _model = *model;
        _isFinished = true;
        return true;
    }

    std::optional<core::Error> put(Chunk chunk) override
    {
        const KeyBytes key = bytesOf(chunk.key);
        const std::vector<std::byte> bytes = encoded(chunk);
        if (auto failed = write(std::as_bytes(std::span(key)), bytes))
            return failed;
        _directory.push_back(entryOf(chunk));
        _open += bytes.size();
        return _open < kCommitEvery ? std::nullopt : commit();
    }

    std::optional<core::Error> finish(const StoredModel& model) override
    {
        const std::vector<std::byte> directory = encoded(_directory);
        if (auto failed = write(std::as_bytes(std::span(kDirectoryKey)), directory))
            return failed;
        const std::string text = encoded(model);
        if (auto failed =
                write(std::as_bytes(std::span(kModelKey)), std::as_bytes(std::span(text))))
            return failed;
        if (auto failed = commit())
            return failed;
        if (const int code = ::mdb_env_sync(_environment.handle(), 1); code != 0)
            return error("written", code);
        std::error_code failed;
        std::filesystem::rename(_written, _path, failed);
        if (failed)
            return core::Error{
                core::ErrorCode::inputOutput,
                _path.string() + ": can't be given its name: " + failed.message()};
        std::filesystem::remove(lockOf(_written), failed);
        _model = model;
        _isFinished = true;
        if (const int code = makeDurable(folderOf(_path)); code != 0)
            return error("given its name for good", code);
        return std::nullopt;
    }

    [[nodiscard]] const StoredModel& model() const override { return _model; }
    [[nodiscard]] std::string place() const override { return _path.string(); }

    [[nodiscard]] std::vector<ChunkKey> keys() const override
    {
        std::vector<ChunkKey> keys;
        Transaction transaction;
        MDB_cursor* cursor = nullptr;
        if (transaction.begin(_environment, MDB_RDONLY) != 0 ||
            ::mdb_cursor_open(transaction.handle(), _environment.table(), &cursor) != 0)
            return keys;
        MDB_val key{};
        MDB_val value{};
        while (::mdb_cursor_get(cursor, &key, &value, MDB_NEXT) == 0)
            if (key.mv_size == std::tuple_size_v<KeyBytes>)
                keys.push_back(keyOf(static_cast<const unsigned char*>(key.mv_data)));
        ::mdb_cursor_close(cursor);
        return keys;
    }

    [[nodiscard]] core::Result<std::vector<ChunkEntry>> directory() const override
    {
        const auto bytes = read(std::as_bytes(std::span(kDirectoryKey)));
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
        const KeyBytes name = bytesOf(key);
        const auto bytes = read(std::as_bytes(std::span(name)));
        if (!bytes)
            return tl::unexpected(bytes.error());
        if (!*bytes)
            return std::optional<Chunk>();
        auto chunk = decodedChunk(**bytes, key);
        if (!chunk)
            return tl::unexpected(chunk.error().within(_path.string()));
        return std::optional(std::move(*chunk));
    }

    /// What LMDB makes beside a file that is written.
    static std::filesystem::path lockOf(const std::filesystem::path& path)
    {
        return path.string() + "-lock";
    }

private:
    [[nodiscard]] core::Error error(const char* what, int code) const
    {
        return {
            core::ErrorCode::inputOutput,
            _path.string() + ": can't be " + what + ": " + reasonOf(code)};
    }

    std::optional<core::Error>
    write(std::span<const std::byte> name, std::span<const std::byte> bytes)
    {
        if (_writing == nullptr) {
            _writing = std::make_unique<Transaction>();
            if (const int code = _writing->begin(_environment, 0); code != 0) {
                _writing.reset();
                return error("written", code);
            }
        }
        MDB_val key = valueOf(name);
        MDB_val value = valueOf(bytes);
        if (const int code = ::mdb_put(_writing->handle(), _environment.table(), &key, &value, 0);
            code != 0)
            return error("written", code);
        return std::nullopt;
    }
    std::optional<core::Error> commit()
    {
        const int code = _writing->commit();
        _writing.reset();
        _open = 0;
        return code == 0 ? std::nullopt : std::optional(error("written", code));
    }

    [[nodiscard]] core::Result<std::optional<std::vector<std::byte>>>
    read(std::span<const std::byte> name) const
    {
        Transaction transaction;
        if (const int code = transaction.begin(_environment, MDB_RDONLY); code != 0)
            return tl::unexpected(error("read", code));
        MDB_val key = valueOf(name);
        MDB_val value{};
        const int code = ::mdb_get(transaction.handle(), _environment.table(), &key, &value);
        if (code == MDB_NOTFOUND)
            return std::optional<std::vector<std::byte>>();
        if (code != 0)
            return tl::unexpected(error("read", code));
        const auto* const begin = static_cast<const std::byte*>(value.mv_data);
        return std::optional(std::vector<std::byte>(begin, begin + value.mv_size));
    }

    std::filesystem::path _path;
    std::filesystem::path _written;  ///< while it is not done
    std::optional<WriterLock> _lock; ///< of what is written
    Environment _environment;
    std::unique_ptr<Transaction> _writing;
    std::vector<ChunkEntry> _directory; ///< of what was put
    std::size_t _open = 0;              ///< put since the last commit [bytes]
    StoredModel _model;
    bool _isFinished = false;
};

} // namespace

core::Result<std::unique_ptr<ChunkStore>> createStore(const std::filesystem::path& path)
{
    const std::filesystem::path part = path.string() + ".part";
    auto lock = WriterLock::take(part, path);
    if (!lock)
        return tl::unexpected(lock.error());
    auto environment = Environment::open(part, true);
    if (!environment) {
        std::error_code ignored;
        std::filesystem::remove(LmdbStore::lockOf(part), ignored);
        std::filesystem::remove(part, ignored);
        return tl::unexpected(environment.error());
    }
    return std::make_unique<LmdbStore>(path, part, std::move(*lock), std::move(*environment));
}

core::Result<std::unique_ptr<ChunkStore>> openStore(const std::filesystem::path& path)
{
    std::error_code failed;
    if (!std::filesystem::is_regular_file(path, failed))
        return core::failure(
            core::ErrorCode::inputOutput,
            path.string() + ": " + (failed ? failed.message() : "is not a file"));
    auto environment = Environment::open(path, false);
    if (!environment)
        return tl::unexpected(environment.error());
    auto store = std::make_unique<LmdbStore>(
        path, std::filesystem::path(), std::nullopt, std::move(*environment));
    if (const auto model = store->readModel(); !model)
        return tl::unexpected(model.error());
    return std::unique_ptr<ChunkStore>(std::move(store));
}

} // namespace isofront::voxels
