#include "SceneRegistry.h"

#include "ClientWords.h"
#include "SceneFiles.h"

#include <isofront/exchange/OutputFile.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <fstream>
#include <random>
#include <sstream>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecordFile = "scene.json";

std::string newId()
{
    std::random_device device;
    std::string id;
    for (int word = 0; word < 4; ++word) {
        std::uint32_t bits = device();
        for (int digit = 0; digit < 8; ++digit, bits >>= 4U)
            id += "0123456789abcdef"[bits & 15U];
    }
    return id;
}

bool isId(const std::string& text)
{
    return text.size() == 32 && text.find_first_not_of("0123456789abcdef") == std::string::npos;
}

using Microseconds = std::chrono::sys_time<std::chrono::microseconds>;

std::string shown(Microseconds time)
{
    const auto whole = std::chrono::floor<std::chrono::seconds>(time);
    const std::time_t seconds = std::chrono::system_clock::to_time_t(whole);
    std::tm utc{};
    gmtime_r(&seconds, &utc);
    std::array<char, 32> text{};
    std::string shown(
        text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &utc));
    const std::string fraction = std::to_string((time - whole).count());
    return shown + "." + std::string(6 - fraction.size(), '0') + fraction + "Z";
}

core::Error storageError(const fs::path& path, const std::error_code& error)
{
    return {
        core::ErrorCode::inputOutput,
        "the scene can't be stored: " + path.string() + ": " + error.message()};
}

std::uint64_t bytesOf(const SceneRecord& record)
{
    return record.description ? record.description->memoryBytes : 0;
}

/// Waits until the names in a folder survive if the machine goes down.
void makeDurable(const fs::path& folder)
{
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0)
        return;
    fsync(descriptor);
    close(descriptor);
}

/// How often a scene is looked at that never came to its end: the process may have died of it.
constexpr std::uint32_t kMostAttempts = 2;

} // namespace

SceneRegistry::SceneRegistry(const Settings& settings, Log& log, Metrics& metrics)
    : _settings(settings), _log(log), _metrics(metrics), _folder(settings.data / "scenes")
{
}

SceneRegistry::~SceneRegistry()
{
    stop();
}

void SceneRegistry::stop()
{
    _stop.request_stop();
    _preparer.request_stop();
}

core::Result<std::unique_ptr<SceneRegistry>>
SceneRegistry::open(const Settings& settings, Log& log, Metrics& metrics)
{
    std::unique_ptr<SceneRegistry> registry(new SceneRegistry(settings, log, metrics));
    if (const auto taken = registry->takeUp(); !taken)
        return tl::unexpected(taken.error());
    registry->_preparer = std::jthread(
        [self = registry.get()](const std::stop_token& stop) { self->prepareAll(stop); });
    return registry;
}

core::Result<void> SceneRegistry::takeUp()
{
    std::error_code error;
    fs::create_directories(_folder, error);
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            "data: " + _folder.string() + ": can't be made: " + error.message() +
                " (choose another folder with --data)");
    fs::directory_iterator entry(_folder, error);
    for (; !error && entry != fs::directory_iterator(); entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        std::error_code ignored;
        if (isId(name))
            takeUpScene(entry->path());
        else if (name.starts_with(".new-") || name.starts_with(".gone-"))
            fs::remove_all(entry->path(), ignored); // of a process that was killed
    }
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            "data: " + _folder.string() + ": can't be listed: " + error.message());
    return {};
}

void SceneRegistry::takeUpScene(const fs::path& folder)
{
    std::ifstream in(folder / kRecordFile, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    auto record = parseRecord(text.str());
    if (!record || record->id != folder.filename().string()) {
        _log.write(
            LogLevel::error,
            "scene left out",
            {{"folder", folder.string()},
             {"why", record ? "its record is of another scene" : record.error().message}});
        return;
    }
    _storedBytes += record->storedBytes;
    if (record->state == SceneRecord::State::preparing && record->attempts >= kMostAttempts) {
        record->state = SceneRecord::State::failed;
        record->failure = "the service ended each time that it read this";
    }
    if (record->state == SceneRecord::State::preparing)
        _toPrepare.push_back(record->id);
    _records.emplace(record->id, std::move(*record));
}

std::vector<SceneRecord> SceneRegistry::list() const
{
    std::vector<SceneRecord> records;
    {
        const std::scoped_lock lock(_mutex);
        for (const auto& [id, record] : _records)
            records.push_back(record);
    }
    std::ranges::stable_sort(records, {}, &SceneRecord::created);
    return records;
}

std::optional<SceneRecord> SceneRegistry::find(const std::string& id) const
{
    const std::scoped_lock lock(_mutex);
    const auto found = _records.find(id);
    return found == _records.end() ? std::nullopt : std::optional(found->second);
}

core::Result<SceneRecord> SceneRegistry::create(const std::string& name, const SceneOrigin& origin)
{
    bool isFolder = false;
    if (origin.kind == SceneOrigin::Kind::procedural) {
        if (const auto good = checkFormula(origin.text); !good)
            return core::failure(good.error().code, inClientWords(good.error().message, ""));
    } else {
        const auto file = sourceFileIn(_settings.sources, origin.text);
        if (!file)
            return tl::unexpected(file.error());
        std::error_code ignored;
        isFolder = fs::is_directory(*file, ignored);
    }
    if (const auto good = checkOptions(origin.options, origin, isFolder); !good)
        return tl::unexpected(good.error());
    return store(name, origin, nullptr, nullptr);
}

core::Result<SceneRecord> SceneRegistry::create(
    const std::string& name, const SceneOrigin& origin, UploadedFile& file, BodyRoom* room)
{
    if (const auto good = checkOptions(origin.options, origin, false); !good)
        return tl::unexpected(good.error());
    return store(name, origin, &file, room);
}

/// Bytes of the storage that an upload under way takes.
class SceneRegistry::Room final : public BodyRoom {
public:
    explicit Room(SceneRegistry& registry) : _registry(registry) {}
    Room(const Room&) = delete;
    Room& operator=(const Room&) = delete;
    ~Room() override
    {
        const std::scoped_lock lock(_registry._mutex);
        _registry._storedBytes -= _bytes;
    }

    std::optional<Response> extend(std::uint64_t bytes) override
    {
        const std::scoped_lock lock(_registry._mutex);
        if (bytes <= _bytes)
            return std::nullopt;
        if (auto full = _registry.storageExceeded(bytes - _bytes))
            return problem(507, full->message);
        _registry._storedBytes += bytes - _bytes;
        _bytes = bytes;
        return std::nullopt;
    }
    std::uint64_t take() override { return std::exchange(_bytes, 0); }

private:
    SceneRegistry& _registry;
    std::uint64_t _bytes = 0;
};

std::optional<core::Error> SceneRegistry::scenesExceeded() const
{
    if (_records.size() + _comingScenes < _settings.scenes)
        return std::nullopt;
    return core::Error{
        core::ErrorCode::resourceLimit,
        "there are as many scenes as may be (" + std::to_string(_settings.scenes) +
            "): delete one"};
}

std::optional<core::Error> SceneRegistry::storageExceeded(std::uint64_t more) const
{
    // what was stored under a larger limit may be more than there may be
    if (_storedBytes <= _settings.storageBytes && more <= _settings.storageBytes - _storedBytes)
        return std::nullopt;
    return core::Error{
        core::ErrorCode::resourceLimit,
        "all uploads together, those under way included, may take " +
            std::to_string(_settings.storageBytes) + " bytes: delete a scene"};
}

core::Result<std::shared_ptr<BodyRoom>> SceneRegistry::expectUpload(const SceneOrigin& origin)
{
    if (const auto good = checkOptions(origin.options, origin, false); !good)
        return tl::unexpected(good.error());
    const std::scoped_lock lock(_mutex);
    if (auto full = scenesExceeded())
        return tl::unexpected(std::move(*full));
    return std::make_shared<Room>(*this);
}

core::Result<SceneRecord> SceneRegistry::store(
    const std::string& name, const SceneOrigin& origin, UploadedFile* file, BodyRoom* room)
{
    SceneRecord record;
    record.id = newId();
    record.name = name.empty() ? origin.text : name;
    record.origin = origin;
    std::error_code error;
    if (file != nullptr)
        record.storedBytes = fs::file_size(file->path(), error);
    {
        const std::scoped_lock lock(_mutex);
        if (auto full = scenesExceeded())
            return tl::unexpected(std::move(*full));
        if (room != nullptr)
            _storedBytes -= room->take();
        if (auto full = record.storedBytes > 0 ? storageExceeded(record.storedBytes) : std::nullopt)
            return tl::unexpected(std::move(*full));
        ++_comingScenes;
        _storedBytes += record.storedBytes;
        // so that they can be listed in the order in which they were made
        _lastCreated = std::max(
            std::chrono::floor<std::chrono::microseconds>(std::chrono::system_clock::now()),
            _lastCreated + std::chrono::microseconds(1));
        record.created = shown(_lastCreated);
    }
    const fs::path coming = _folder / (".new-" + record.id);
    core::Result<void> stored;
    if (fs::create_directory(coming, error); error)
        stored = tl::unexpected(storageError(coming, error));
    if (stored && file != nullptr)
        stored = file->moveTo(coming / origin.text);
    if (stored)
        stored = write(record, coming);
    if (stored) {
        makeDurable(coming);
        if (fs::rename(coming, _folder / record.id, error); error)
            stored = tl::unexpected(storageError(coming, error));
        makeDurable(_folder);
    }
    if (!stored)
        fs::remove_all(coming, error);
    const std::scoped_lock lock(_mutex);
    --_comingScenes;
    if (!stored) {
        _storedBytes -= record.storedBytes;
        return tl::unexpected(stored.error());
    }
    _records.emplace(record.id, record);
    _toPrepare.push_back(record.id);
    _changed.notify_all();
    return record;
}

core::Result<void> SceneRegistry::write(const SceneRecord& record, const fs::path& folder) const
{
    auto out = exchange::OutputFile::create(folder / kRecordFile);
    if (!out)
        return tl::unexpected(out.error());
    out->write(toText(record));
    if (const auto written = out->commit(); !written)
        return tl::unexpected(written.error());
    return {};
}

core::Result<bool> SceneRegistry::remove(const std::string& id)
{
    std::error_code error;
    const fs::path gone = _folder / (".gone-" + id);
    {
        const std::scoped_lock lock(_mutex);
        const auto found = _records.find(id);
        if (found == _records.end())
            return false;
        fs::rename(_folder / id, gone, error);
        if (error)
            return core::failure(
                core::ErrorCode::inputOutput, "the scene can't be deleted: " + error.message());
        _storedBytes -= found->second.storedBytes;
        _records.erase(found);
        if (const auto opened = _opened.find(id); opened != _opened.end() && opened->second.scene)
            _opened.erase(opened); // those who hold it keep it
        makeRoom();
    }
    makeDurable(_folder);
    fs::remove_all(gone, error); // at the next start, if it can't be now
    return true;
}

core::Result<sources::Source>
SceneRegistry::read(const SceneRecord& record, std::uint64_t limit) const
{
    sources::SourceOptions options = record.origin.options;
    options.memoryLimit = limit;
    options.readsOtherFiles = record.origin.kind == SceneOrigin::Kind::file;
    options.stop = _stop.get_token();
    std::string text = record.origin.text;
    std::string hidden; // clients have no business with the folders of this machine
    if (record.origin.kind == SceneOrigin::Kind::upload) {
        const fs::path file = _folder / record.id / record.origin.text;
        if (const auto contained = checkSelfContained(file); !contained)
            return tl::unexpected(contained.error().within(record.origin.text));
        hidden = (_folder / record.id / "").string();
        text = file.string();
    } else if (record.origin.kind == SceneOrigin::Kind::file) {
        const auto file = sourceFileIn(_settings.sources, record.origin.text);
        if (!file)
            return tl::unexpected(file.error());
        std::error_code ignored;
        hidden = (fs::canonical(_settings.sources, ignored) / "").string();
        text = file->string();
    }
    auto source = sources::openSource(text, options);
    if (!source)
        return core::failure(source.error().code, inClientWords(source.error().message, hidden));
    for (std::string& note : source->notes)
        note = inClientWords(std::move(note), hidden);
    return source;
}

/// As `read`; what libraries throw is a failure of the scene's.
core::Result<sources::Source> SceneRegistry::readSafely(const SceneRecord& record) const
{
    try {
        return read(record, _settings.memoryBytes / 2);
    } catch (const std::bad_alloc&) {
        return core::failure(
            core::ErrorCode::resourceLimit,
            record.origin.text + ": the service has not enough memory for it");
    } catch (const std::exception& error) {
        return core::failure(
            core::ErrorCode::badData,
            record.origin.text + ": can't be read: " + std::string(error.what()));
    }
}

void SceneRegistry::prepareAll(const std::stop_token& stop)
{
    while (true) {
        std::string id;
        {
            std::unique_lock lock(_mutex);
            if (!_changed.wait(lock, stop, [this] { return !_toPrepare.empty(); }))
                return;
            id = _toPrepare.front();
            _toPrepare.pop_front();
        }
        prepare(id, stop);
    }
}

void SceneRegistry::prepare(const std::string& id, const std::stop_token& stop)
{
    auto record = find(id);
    if (!record)
        return;
    const auto begin = std::chrono::steady_clock::now();
    ++record->attempts;
    const auto write = [&] {
        if (const auto written = this->write(*record, _folder / id); !written && find(id))
            _log.write(LogLevel::error, "scene not stored", {{"why", written.error().message}});
    };
    write();
    auto source = readSafely(*record);
    try {
        if (source)
            record->description = describe(*source);
    } catch (const std::exception& error) {
        source = core::failure(
            core::ErrorCode::resourceLimit,
            record->origin.text + ": can't be looked at: " + error.what());
    }
    if (stop.stop_requested())
        return; // what was cut short is no failure of the scene's
    record->state = source ? SceneRecord::State::ready : SceneRecord::State::failed;
    record->failure = source ? "" : source.error().message;
    write();
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    nlohmann::ordered_json fields{{"scene", id}, {"seconds", seconds}};
    if (!source)
        fields["why"] = record->failure;
    const std::scoped_lock lock(_mutex);
    const auto found = _records.find(id);
    if (found == _records.end())
        return; // deleted meanwhile
    found->second = *record;
    _log.write(
        source ? LogLevel::info : LogLevel::warning,
        source ? "scene ready" : "scene refused",
        fields);
    // whoever has made it will look at it next
    if (source && !_opened.contains(id))
        _opened[id] = {
            std::make_shared<const OpenScene>(OpenScene{*record, std::move(*source)}),
            bytesOf(*record),
            ++_uses};
    makeRoom();
}

std::uint64_t SceneRegistry::makeRoom()
{
    while (true) {
        std::uint64_t bytes = 0;
        std::size_t scenes = 0;
        auto oldest = _opened.end();
        for (auto opened = _opened.begin(); opened != _opened.end(); ++opened) {
            bytes += opened->second.bytes;
            if (!opened->second.scene)
                continue;
            ++scenes;
            if (opened->second.scene.use_count() == 1 &&
                (oldest == _opened.end() || opened->second.lastUse < oldest->second.lastUse))
                oldest = opened;
        }
        if (bytes <= _settings.memoryBytes / 2 || oldest == _opened.end()) {
            _metrics.set(Metrics::Level::openScenes, static_cast<double>(scenes));
            _metrics.set(Metrics::Level::sceneBytes, static_cast<double>(bytes));
            return bytes;
        }
        _opened.erase(oldest);
    }
}

class SceneRegistry::Reading {
public:
    Reading(SceneRegistry& registry, const std::string& id) : _registry(registry), _id(id) {}
    Reading(const Reading&) = delete;
    Reading& operator=(const Reading&) = delete;
    ~Reading()
    {
        const std::scoped_lock lock(_registry._mutex);
        const auto found = _registry._opened.find(_id);
        if (found != _registry._opened.end() && !found->second.scene)
            _registry._opened.erase(found);
        _registry._changed.notify_all();
    }

private:
    SceneRegistry& _registry;
    std::string _id;
};

core::Result<std::shared_ptr<const OpenScene>> SceneRegistry::acquire(const SceneRecord& record)
{
    if (record.state != SceneRecord::State::ready)
        return core::failure(
            core::ErrorCode::usage,
            record.state == SceneRecord::State::failed ? record.failure
                                                       : "the scene isn't ready yet");
    const auto full = [] {
        return core::failure(
            core::ErrorCode::resourceLimit,
            "other scenes are open and take all the memory that the service may: try again");
    };
    {
        std::unique_lock lock(_mutex);
        // another may be reading it
        const bool isOver = !_changed.wait(lock, _stop.get_token(), [&] {
            const auto opened = _opened.find(record.id);
            return opened == _opened.end() || opened->second.scene;
        });
        if (isOver)
            return core::failure(core::ErrorCode::interrupted, "the service is ending");
        Opened& opened = _opened[record.id];
        opened.lastUse = ++_uses;
        if (opened.scene)
            return opened.scene;
        opened.bytes = bytesOf(record); // before it is read, so that the sum never exceeds
        if (makeRoom() > _settings.memoryBytes) {
            _opened.erase(record.id);
            _changed.notify_all();
            return full();
        }
    }
    const Reading reading(*this, record.id);
    auto source = readSafely(record);
    if (!source)
        return tl::unexpected(source.error());
    auto scene = std::make_shared<const OpenScene>(OpenScene{record, std::move(*source)});
    const std::scoped_lock lock(_mutex);
    if (!_records.contains(record.id))
        return core::failure(core::ErrorCode::usage, "the scene has just been deleted");
    _opened[record.id].scene = scene;
    makeRoom();
    return scene;
}

} // namespace isofront::server
