#pragma once

#include "StreamViewer.h"
#include "TemporaryFolder.h"

#include <isofront/server/Server.h>

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

namespace isofront::server {

/// The real service with one scene, and clients of its streams over sockets.
class Streamed : public testing::Test {
protected:
    using Viewer = StreamViewer;

    Streamed()
    {
        settings.port = 0;
        settings.data = folder.path / "data";
        settings.logLevel = "error";
        settings.anonymous = {"read", "write", "admin"};
        settings.workers = 4;
    }

    /// The service; anew, if there was one.
    void start()
    {
        server.reset();
        auto started = Server::start(settings);
        ASSERT_TRUE(started) << started.error().message;
        server = std::move(*started);
        if (target.empty()) {
            const StreamedScene scene = makeScene(server->port());
            target = scene.target;
            view = scene.view;
        }
    }

    double metric(const std::string& name) const
    {
        HttpClient client(server->port());
        const std::string text = client.ask("GET", "/metrics").body;
        const std::size_t at = text.find("\n" + name + " ");
        return at == std::string::npos ? -1 : std::stod(text.substr(at + name.size() + 2));
    }
    void awaitStreams(double count) const
    {
        while (metric("isofront_streams") != count)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }

    TemporaryFolder folder;
    Settings settings;
    std::unique_ptr<Server> server;
    std::string target;
    hierarchy::View view;
};

} // namespace isofront::server
