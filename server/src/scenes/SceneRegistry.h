#pragma once

#include "../Log.h"
#include "../Metrics.h"
#include "../api/Message.h"
#include "SceneRecord.h"

#include <isofront/core/Result.h>
#include <isofront/server/Settings.h>
#include <isofront/sources/Source.h>

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace isofront::server {

/// A scene whose field is in memory.
struct OpenScene {
    SceneRecord record;
    sources::Source source;
};

/// The scenes that the service keeps. Each has a folder, with its record and what was uploaded for
/// it, which appears when both are whole and goes when it is deleted; so a service that is killed
/// comes back with all scenes that clients were told of. What is new is looked at in the background
/// before it counts as ready.
///
/// Thread: any.
class SceneRegistry {
public:
    /// Takes up the scenes of a folder. Those whose record can't be read are named in the log and
    /// left alone.
    static core::Result<std::unique_ptr<SceneRegistry>>
    open(const Settings& settings, Log& log, Metrics& metrics);

    SceneRegistry(const SceneRegistry&) = delete;
    SceneRegistry& operator=(const SceneRegistry&) = delete;
    /// What is being looked at is looked at again the next time.
    ~SceneRegistry();

    /// Cuts short what is being read; nothing can be acquired any more.
    void stop();

    [[nodiscard]] std::vector<SceneRecord> list() const; ///< oldest first
    [[nodiscard]] std::optional<SceneRecord> find(const std::string& id) const;
    /// Makes a scene of a formula or a file of the service's.
    /// Errors: usage for names that aren't there and options that have no effect on them,
    /// resourceLimit if there are too many scenes, inputOutput if it can't be stored.
    core::Result<SceneRecord> create(const std::string& name, const SceneOrigin& origin);
    /// Makes a scene of a file that a client has sent.
    /// @param room  what `expectUpload` gave for it; none: what it takes is only counted now
    core::Result<SceneRecord> create(
        const std::string& name,
        const SceneOrigin& origin,
        UploadedFile& file,
        BodyRoom* room = nullptr);
    /// Before a client sends a file: whether a scene could be made of it. What it says that it will
    /// send counts as stored from then on.
    core::Result<std::shared_ptr<BodyRoom>> expectUpload(const SceneOrigin& origin);
    /// @return whether there was one
    core::Result<bool> remove(const std::string& id);

    /// The scene with its field, which is read if it isn't in memory. Those that nobody holds go
    /// again, least recently used first, when there are more than half of
    /// `Settings::memoryBytes` of them.
    /// Errors: those of opening; usage for a scene that isn't ready, or was deleted meanwhile;
    /// resourceLimit if there is no room beside those that are held; interrupted after `stop`.
    core::Result<std::shared_ptr<const OpenScene>> acquire(const SceneRecord& record);

private:
    struct Opened {
        std::shared_ptr<const OpenScene> scene; ///< none while it is being read
        std::uint64_t bytes = 0;
        std::uint64_t lastUse = 0;
    };
    /// The entry of a scene while it is being read; goes if that fails, whichever way.
    class Reading;

    SceneRegistry(const Settings& settings, Log& log, Metrics& metrics);
    core::Result<void> takeUp();
    void takeUpScene(const std::filesystem::path& folder);
    class Room;
    core::Result<SceneRecord>
    store(const std::string& name, const SceneOrigin& origin, UploadedFile* file, BodyRoom* room);
    // holding the lock: why there is no room for another scene, or for more bytes
    [[nodiscard]] std::optional<core::Error> scenesExceeded() const;
    [[nodiscard]] std::optional<core::Error> storageExceeded(std::uint64_t more) const;
    core::Result<void> write(const SceneRecord& record, const std::filesystem::path& folder) const;
    core::Result<sources::Source> read(const SceneRecord& record, std::uint64_t limit) const;
    void prepareAll(const std::stop_token& stop);
    void prepare(const std::string& id, const std::stop_token& stop);
    core::Result<sources::Source> readSafely(const SceneRecord& record) const;
    std::uint64_t makeRoom(); // holding the lock

    Settings _settings;
    Log& _log;
    Metrics& _metrics;
    std::filesystem::path _folder;
    mutable std::mutex _mutex;
    std::condition_variable_any _changed; ///< there is something to prepare, or something was read
    std::map<std::string, SceneRecord> _records;
    std::map<std::string, Opened> _opened;
    std::deque<std::string> _toPrepare;
    std::uint64_t _uses = 0;
    std::uint64_t _storedBytes = 0; ///< and those of uploads that are under way
    std::chrono::sys_time<std::chrono::microseconds> _lastCreated;
    std::uint64_t _comingScenes = 0; ///< being stored
    std::stop_source _stop;
    std::jthread _preparer; // ends first
};

} // namespace isofront::server
