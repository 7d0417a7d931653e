#pragma once

#include "HttpClient.h"
#include "StreamClient.h"
#include "WebSocketClient.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <thread>

namespace isofront::server {

/// A scene, and where to look at it from.
struct StreamedScene {
    std::string target; ///< of its stream
    hierarchy::View view;
};

/// Has a service make a sphere, and waits until it is ready.
inline StreamedScene makeScene(std::uint16_t port)
{
    using Json = nlohmann::ordered_json;
    HttpClient client(port);
    const HttpAnswer made = client.ask(
        "POST",
        "/v1/scenes",
        "Content-Type: application/json\r\n",
        R"({"formula": "proc:sphere"})");
    EXPECT_EQ(made.status, 201) << made.body;
    if (made.status != 201)
        return {};
    const std::string id = Json::parse(made.body).at("id");
    Json scene;
    do {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        scene = Json::parse(client.ask("GET", "/v1/scenes/" + id).body);
    } while (scene.at("state") == "preparing");
    EXPECT_EQ(scene.at("state"), "ready") << scene;
    StreamedScene result{"/v1/scenes/" + id + "/stream", {}};
    const Json& look = scene.at("description").at("view");
    for (std::size_t axis = 0; axis < 3; ++axis) {
        result.view.eye[axis] = look.at("eye").at(axis);
        result.view.forward[axis] =
            look.at("target").at(axis).get<double>() - result.view.eye[axis];
        result.view.up[axis] = look.at("up").at(axis);
    }
    result.view.width = 160;
    result.view.height = 120;
    return result;
}

/// Somebody who looks at a scene.
struct StreamViewer {
    StreamViewer(std::uint16_t port, const std::string& target) : socket(port, target) {}

    /// @param former  the payloads that are still here
    void greet(
        const hierarchy::View& view,
        const std::map<std::uint64_t, StreamClient::Payload>& former = {})
    {
        ASSERT_EQ(socket.handshake.status, 101) << socket.handshake.body;
        std::map<std::uint64_t, std::uint32_t> held;
        for (const auto& [hash, payload] : former)
            held[hash] = payload.bytes;
        client.payloads = former;
        socket.send(helloMessage(1'000'000, held));
        socket.send(creditsMessage(std::uint64_t{1} << 30U));
        socket.send(viewMessage(view, 4));
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

} // namespace isofront::server
