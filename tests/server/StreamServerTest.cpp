// Streams of the real service, over sockets.

#include "StreamClient.h"
#include "TemporaryFolder.h"
#include "WebSocketClient.h"

#include <isofront/server/Server.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <memory>
#include <thread>
#include <vector>

namespace isofront::server {
namespace {

using Json = nlohmann::ordered_json;

class Streamed : public testing::Test {
protected:
    Streamed()
    {
        settings.port = 0;
        settings.data = folder.path / "data";
        settings.logLevel = "error";
        settings.anonymous = {"read", "write", "admin"};
        settings.workers = 4;
    }

    void start()
    {
        server.reset();
        auto started = Server::start(settings);
        ASSERT_TRUE(started) << started.error().message;
        server = std::move(*started);
        if (target.empty())
            makeScene();
    }
    void makeScene()
    {
        HttpClient client(server->port());
        const HttpAnswer made = client.ask(
            "POST",
            "/v1/scenes",
            "Content-Type: application/json\r\n",
            R"({"formula": "proc:sphere"})");
        ASSERT_EQ(made.status, 201) << made.body;
        const std::string id = Json::parse(made.body).at("id");
        Json scene;
        do {
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
            scene = Json::parse(client.ask("GET", "/v1/scenes/" + id).body);
        } while (scene.at("state") == "preparing");
        ASSERT_EQ(scene.at("state"), "ready") << scene;
        target = "/v1/scenes/" + id + "/stream";
        const Json& look = scene.at("description").at("view");
        for (std::size_t axis = 0; axis < 3; ++axis) {
            view.eye[axis] = look.at("eye").at(axis);
            view.forward[axis] = look.at("target").at(axis).get<double>() - view.eye[axis];
            view.up[axis] = look.at("up").at(axis);
        }
        view.width = 160;
        view.height = 120;
    }

    /// Somebody who looks at the scene.
    struct Viewer {
        Viewer(std::uint16_t port, const std::string& itsTarget) : socket(port, itsTarget) {}

        void greet(const hierarchy::View& itsView)
        {
            ASSERT_EQ(socket.handshake.status, 101) << socket.handshake.body;
            socket.send(helloMessage(1'000'000));
            socket.send(creditsMessage(std::uint64_t{1} << 30U));
            socket.send(viewMessage(itsView, 4));
        }
        /// Takes one message.
        bool listen()
        {
            const auto frame = socket.receive();
            if (!frame || frame->opcode != 2)
                return false;
            const std::uint64_t before = client.transaction;
            client.take(frame->bytes());
            if (client.transaction != before)
                socket.send(acknowledgeMessage(client.transaction));
            return true;
        }
        void settle()
        {
            while (!client.isSettled && !testing::Test::HasFailure())
                ASSERT_TRUE(listen()) << "the service has gone";
        }

        WebSocketClient socket;
        StreamClient client;
    };

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

TEST_F(Streamed, showsTwoClientsTheSameAndExtractsItOnce)
{
    start();
    Viewer one(server->port(), target);
    one.greet(view);
    one.settle();
    const double extracted = metric("isofront_cells_extracted_total");
    Viewer other(server->port(), target);
    other.greet(view);
    other.settle();
    EXPECT_TRUE(one.client.isWelcomed);
    EXPECT_GT(one.client.host.triangles(), 500U);
    EXPECT_EQ(one.client.host.triangles(), other.client.host.triangles());
    EXPECT_LT(metric("isofront_cells_extracted_total"), 1.2 * extracted);
    EXPECT_GT(metric("isofront_cells_shared_total"), 0.5 * extracted);
    EXPECT_EQ(metric("isofront_streams"), 2);
}

TEST_F(Streamed, servesManyClientsOfWhomSomeVanish)
{
    settings.streams = 20;
    start();
    std::vector<std::unique_ptr<Viewer>> viewers;
    for (int i = 0; i < 20; ++i) {
        viewers.push_back(std::make_unique<Viewer>(server->port(), target));
        viewers.back()->client.looksForCracks = i == 0;
        viewers.back()->greet(view);
    }
    WebSocketClient tooMany(server->port(), target);
    EXPECT_EQ(tooMany.handshake.status, 503);
    for (std::size_t i = 1; i < viewers.size(); i += 2)
        viewers[i].reset(); // in the middle of it all
    for (std::size_t i = 0; i < viewers.size(); i += 2)
        viewers[i]->settle();
    for (std::size_t i = 0; i < viewers.size(); i += 2)
        EXPECT_EQ(viewers[i]->client.host.triangles(), viewers[0]->client.host.triangles());
    awaitStreams(10);
    viewers.clear();
    awaitStreams(0);
}

TEST_F(Streamed, refusesWhatItCannotShow)
{
    start();
    EXPECT_EQ(WebSocketClient(server->port(), "/v1/scenes/none/stream").handshake.status, 404);
    HttpClient plain(server->port());
    EXPECT_EQ(plain.ask("GET", target).status, 426);

    WebSocketClient rude(server->port(), target);
    rude.send(creditsMessage(1)); // without a hello
    const auto why = rude.receive();
    ASSERT_TRUE(why);
    EXPECT_EQ(why->bytes()[0], std::byte{0xff});
    const auto end = rude.receive();
    ASSERT_TRUE(end);
    EXPECT_EQ(end->opcode, 8);
    EXPECT_EQ(end->closeCode(), 1000);
}

TEST_F(Streamed, tellsClientsWhenItEndsAndIsThereAgainAfterwards)
{
    start();
    auto viewer = std::make_unique<Viewer>(server->port(), target);
    viewer->greet(view);
    viewer->settle();
    std::jthread ending([this] { server->drain(); });
    std::optional<WebSocketClient::Frame> frame;
    do
        frame = viewer->socket.receive();
    while (frame && frame->opcode != 8);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->closeCode(), 1001);
    viewer->socket.send(frame->bytes(), 8);
    EXPECT_FALSE(viewer->socket.receive()) << "the service closes first";
    const StreamClient former = std::move(viewer->client);
    viewer.reset();
    ending.join();

    start();
    std::map<std::uint64_t, std::uint32_t> held;
    Viewer again(server->port(), target);
    for (const auto& [hash, payload] : former.payloads)
        held[hash] = payload.bytes;
    again.client.payloads = former.payloads;
    again.socket.send(helloMessage(1'000'000, held));
    again.socket.send(creditsMessage(std::uint64_t{1} << 30U));
    again.socket.send(viewMessage(view, 4));
    again.settle();
    EXPECT_EQ(again.client.host.triangles(), former.host.triangles());
    EXPECT_LT(5 * again.client.cells, former.cells);
}

} // namespace
} // namespace isofront::server
