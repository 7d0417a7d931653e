#include "Log.h"
#include "Metrics.h"
#include "Service.h"
#include "api/RaysApi.h"
#include "api/ScenesApi.h"
#include "api/StreamApi.h"
#include "api/SystemApi.h"
#include "api/ViewerApi.h"
#include "http/HttpServer.h"
#include "scenes/SceneRegistry.h"
#include "stream/StreamHub.h"

#include <isofront/core/Jobs.h>
#include <isofront/server/Server.h>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

/// A folder of scenes that no other service uses at the same time.
class DataFolder {
public:
    /// Makes it, for nobody else on this machine, if it isn't there.
    static core::Result<DataFolder> take(const fs::path& path)
    {
        const auto refused = [&](const std::string& why) {
            return core::failure(
                core::ErrorCode::inputOutput,
                "data: " + path.string() + ": " + why + " (choose another folder with --data)");
        };
        std::error_code error;
        const bool isNew = fs::create_directories(path, error);
        if (error)
            return refused("can't be made: " + error.message());
        if (isNew)
            fs::permissions(path, fs::perms::owner_all, error);
        DataFolder folder;
        folder._lock = open((path / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
        if (folder._lock < 0)
            return refused(std::string("can't be written: ") + std::strerror(errno));
        if (flock(folder._lock, LOCK_EX | LOCK_NB) != 0)
            return refused("another service uses it");
        return folder;
    }

    DataFolder(DataFolder&& other) noexcept : _lock(std::exchange(other._lock, -1)) {}
    DataFolder& operator=(DataFolder&&) = delete;
    ~DataFolder()
    {
        if (_lock >= 0)
            close(_lock);
    }

private:
    DataFolder() = default;

    int _lock = -1;
};

/// The folder in which uploads come in, empty: what is there is of a process that was killed.
core::Result<fs::path> makeUploads(const Settings& settings)
{
    const fs::path folder = settings.data / "uploads";
    std::error_code error;
    fs::create_directories(folder, error);
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            "data: " + folder.string() + ": can't be made: " + error.message() +
                " (choose another folder with --data)");
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error))
        if (entry->path().extension() == ".part") {
            std::error_code ignored;
            fs::remove(entry->path(), ignored);
        }
    return folder;
}

} // namespace

struct Server::Parts {
    Parts(const Settings& itsSettings, Tokens tokens, DataFolder folder)
        : settings(itsSettings), data(std::move(folder)), log(settings), streams(settings, metrics),
          service(settings, std::move(tokens), log, metrics)
    {
    }

    ~Parts()
    {
        if (scenes)
            scenes->stop(); // nobody waits for what is still being read
    }

    Settings settings;
    DataFolder data;
    Log log;
    Metrics metrics;
    std::unique_ptr<SceneRegistry> scenes;
    StreamHub streams;
    std::unique_ptr<core::Jobs> jobs = core::makeJobs(); ///< of requests
    Service service;
    std::unique_ptr<HttpServer> http; // first to go
};

Server::Server(std::unique_ptr<Parts> parts) : _parts(std::move(parts)) {}

Server::~Server() = default;

core::Result<std::unique_ptr<Server>> Server::start(const Settings& settings)
{
    Tokens tokens;
    if (!settings.tokens.empty()) {
        auto read = Tokens::read(settings.tokens);
        if (!read)
            return tl::unexpected(read.error());
        tokens = std::move(*read);
    }
    for (const auto& [name, folder] :
         {std::pair("sources", &settings.sources), std::pair("viewer", &settings.viewer)}) {
        std::error_code ignored;
        if (!folder->empty() && !fs::is_directory(*folder, ignored))
            return core::failure(
                core::ErrorCode::inputOutput,
                std::string(name) + ": " + folder->string() + ": there is no such folder");
    }
    ViewerFiles viewer;
    if (!settings.viewer.empty()) {
        auto files = ViewerFiles::read(settings.viewer);
        if (!files)
            return tl::unexpected(files.error());
        viewer = std::move(*files);
    }
    auto data = DataFolder::take(settings.data);
    if (!data)
        return tl::unexpected(data.error());
    const auto uploads = makeUploads(settings);
    if (!uploads)
        return tl::unexpected(uploads.error());
    auto parts = std::make_unique<Parts>(settings, std::move(tokens), std::move(*data));
    std::signal(SIGPIPE, SIG_IGN); // a log that nobody reads any more ends no service
    auto scenes = SceneRegistry::open(settings, parts->log, parts->metrics);
    if (!scenes)
        return tl::unexpected(scenes.error());
    parts->scenes = std::move(*scenes);
    parts->service.add(systemApi(parts->service));
    parts->service.add(scenesApi(*parts->scenes, settings));
    parts->service.add(streamApi(*parts->scenes, parts->streams));
    parts->service.add(raysApi(*parts->scenes, *parts->jobs));
    parts->service.add(viewerApi(std::move(viewer)));
    auto http = HttpServer::start(parts->service, *uploads);
    if (!http)
        return tl::unexpected(http.error());
    parts->http = std::move(*http);
    return std::unique_ptr<Server>(new Server(std::move(parts)));
}

std::uint16_t Server::port() const
{
    return _parts->http->port();
}

std::string Server::address() const
{
    const std::string& host = _parts->settings.host;
    const bool isAny = host == "0.0.0.0" || host == "::";
    const std::string name = isAny                                 ? "localhost"
                             : host.find(':') != std::string::npos ? "[" + host + "]"
                                                                   : host;
    return "http://" + name + ":" + std::to_string(port()) + "/";
}

bool Server::drain()
{
    return _parts->http->drain();
}

} // namespace isofront::server
