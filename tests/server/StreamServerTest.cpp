// Streams of the real service, over sockets.

#include "StreamedFixture.h"
#include "support/Random.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <thread>
#include <vector>

namespace isofront::server {
namespace {

TEST_F(Streamed, showsTwoClientsTheSameAndExtractsItOnce)
{
    start();
    Viewer one(server->port(), target);
    one.greet(view);
    one.settle();
    Viewer other(server->port(), target);
    other.greet(view);
    other.settle();
    EXPECT_TRUE(one.client.isWelcomed);
    EXPECT_GT(one.client.host.triangles(), 500U);
    EXPECT_EQ(one.client.host.triangles(), other.client.host.triangles());
    // counted a moment after they are sent; were nothing shared it would never come
    while (metric("isofront_cells_shared_total") <= 0.5 * metric("isofront_cells_extracted_total"))
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(metric("isofront_streams"), 2);
}

TEST_F(Streamed, servesManyClientsOfWhomSomeVanish)
{
    // fifty: with ISOFRONT_TEST_INTENSITY=2.5
    const auto count = static_cast<std::uint32_t>(std::max(4, tests::trials(20) / 2 * 2));
    settings.streams = count;
    start();
    std::vector<std::unique_ptr<Viewer>> viewers;
    for (std::uint32_t i = 0; i < count; ++i) {
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
    awaitStreams(count / 2);
    viewers.clear();
    awaitStreams(0);
}

TEST_F(Streamed, refusesClientsForWhomThereIsNoRoom)
{
    settings.memoryBytes = 1000; // what is in use may be more: it is looked at when another comes
    start();
    Viewer one(server->port(), target);
    one.greet(view);
    one.settle();
    {
        const WebSocketClient other(server->port(), target);
        EXPECT_EQ(other.handshake.status, 503);
        EXPECT_NE(other.handshake.body.find("memory"), std::string::npos);
    }
    EXPECT_GT(metric("isofront_stream_bytes"), 1000);
    one.socket.hangUp();
    awaitStreams(0);
    // its meshes go when its surface is taken apart, in its own time
    int status = 0;
    while ((status = WebSocketClient(server->port(), target).handshake.status) == 503)
        std::this_thread::yield();
    EXPECT_EQ(status, 101);
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
    Viewer again(server->port(), target);
    again.greet(view, former.payloads);
    again.settle();
    EXPECT_EQ(again.client.host.triangles(), former.host.triangles());
    EXPECT_LT(5 * again.client.cells, former.cells);
}

} // namespace
} // namespace isofront::server
