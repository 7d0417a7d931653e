#include "Log.h"
#include "Metrics.h"
#include "Service.h"
#include "api/ScenesApi.h"
#include "api/SystemApi.h"
#include "http/HttpServer.h"
#include "scenes/SceneRegistry.h"

#include <isofront/server/Server.h>

#include <filesystem>
#include <system_error>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

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
    Parts(const Settings& itsSettings, Tokens tokens)
        : settings(itsSettings), log(settings), service(settings, std::move(tokens), log, metrics)
    {
    }

    Settings settings;
    Log log;
    Metrics metrics;
    std::unique_ptr<SceneRegistry> scenes;
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
    const auto uploads = makeUploads(settings);
    if (!uploads)
        return tl::unexpected(uploads.error());
    auto parts = std::make_unique<Parts>(settings, std::move(tokens));
    auto scenes = SceneRegistry::open(settings, parts->log, parts->metrics);
    if (!scenes)
        return tl::unexpected(scenes.error());
    parts->scenes = std::move(*scenes);
    parts->service.add(systemApi(parts->service));
    parts->service.add(scenesApi(*parts->scenes, settings));
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
