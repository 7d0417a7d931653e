// Clients that are slow, vanish or talk nonsense, and a service that bears with them.

#include "StreamedFixture.h"
#include "support/Random.h"

#include <malloc.h>

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <iterator>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {
namespace {

/// A frame of a client's, masked with zeros: as it is.
std::string frame(unsigned char first, const std::string& content)
{
    std::string bytes{static_cast<char>(first), static_cast<char>(0x80U | content.size())};
    return bytes + std::string(4, '\0') + content;
}

std::string textOf(const std::vector<std::byte>& bytes)
{
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// Whether the service ends it, whatever it says before.
bool isEnded(WebSocketClient& socket)
{
    while (const auto said = socket.receive())
        if (said->opcode == 8)
            return true;
    return socket.isClosed();
}

TEST_F(Streamed, endsWhatIsNoWebSocket)
{
    start();
    const std::vector<std::string> wrong{
        frame(0xc2, "a"),                           // a bit that nobody agreed on
        frame(0x83, "a"),                           // kinds of frames that there aren't
        frame(0x8b, ""),                            //
        std::string("\x82\x01") + "a",              // without a mask
        frame(0x09, ""),                            // a ping in parts
        std::string("\x89\xfe\x00\x7e\0\0\0\0", 8), // a ping too long
        frame(0x80, "a"),                           // more of nothing
        frame(0x02, "a") + frame(0x82, "b"),        // another before the end of the first
        std::string("\x82\xff\x40\0\0\0\0\0\0\0\0\0\0\0", 14), // a length that nobody has
        std::string("\x82\xff\xff\xff\xff\xff", 6) + std::string(8, '\xff'),
        frame(0x88, "a"),                        // a reason to close that is half a number
        frame(0x88, std::string("\x03\xed", 2)), // one that nobody may give
        frame(0x81, "\xff\xfe"),                 // text that is none
        frame(0x81, "hello"),                    // text at all
        frame(0x82, std::string(1, '\x07')),     // a message that there isn't
        frame(0x82, ""),
    };
    for (const std::string& bytes : wrong) {
        WebSocketClient client(server->port(), target);
        ASSERT_EQ(client.handshake.status, 101);
        ASSERT_TRUE(client.sendRaw(bytes));
        EXPECT_TRUE(isEnded(client)) << testing::PrintToString(bytes);
    }
    awaitStreams(0);

    auto generator = tests::random(17);
    const std::vector<std::string> sound{
        frame(0x82, textOf(helloMessage(1000))),
        frame(0x82, textOf(viewMessage(view, 16))),
        frame(0x82, textOf(creditsMessage(100'000))),
        frame(0x82, textOf(isovalueMessage(0.1))),
        frame(0x89, "ping"),
    };
    for (int i = 0; i < tests::trials(60); ++i) {
        WebSocketClient client(server->port(), target);
        ASSERT_EQ(client.handshake.status, 101);
        std::string bytes = i % 2 == 0 ? sound[0] : "";
        for (std::size_t k = 0; k < 1 + tests::below(generator, 5); ++k)
            bytes += sound[tests::below(generator, sound.size())];
        for (std::size_t k = 0; k < tests::below(generator, 4); ++k)
            bytes[tests::below(generator, bytes.size())] =
                static_cast<char>(tests::below(generator, 256));
        client.sendRaw(bytes.substr(0, 1 + tests::below(generator, bytes.size())));
    }
    awaitStreams(0);
    Viewer after(server->port(), target);
    after.greet(view);
    after.settle();
}

TEST_F(Streamed, waitsForSlowClientsWithoutMakingOthersWait)
{
    settings.workers = 2; // fewer than there are slow ones
    start();
    std::vector<std::unique_ptr<Viewer>> mute;
    for (int i = 0; i < 3; ++i) {
        mute.push_back(std::make_unique<Viewer>(server->port(), target));
        mute.back()->greet(view); // and never reads
    }
    Viewer slow(server->port(), target);
    slow.socket.send(helloMessage(0));
    slow.socket.send(creditsMessage(8'000));
    std::uint64_t given = 8'000;
    const auto listenSlowly = [&] {
        ASSERT_TRUE(slow.listen());
        ASSERT_LE(slow.client.charged, given);
        const std::uint64_t more = 8'000 - (given - slow.client.charged);
        slow.socket.send(creditsMessage(more));
        given += more;
    };
    listenSlowly(); // the welcome
    slow.socket.send(viewMessage(view, 4));
    for (int i = 0; i < 3; ++i) {
        Viewer quick(server->port(), target);
        quick.greet(view);
        quick.settle();
        if (!slow.client.isSettled)
            listenSlowly();
    }
    while (!slow.client.isSettled && !HasFailure())
        listenSlowly();
    Viewer other(server->port(), target);
    other.greet(view);
    other.settle();
    EXPECT_EQ(slow.client.host.triangles(), other.client.host.triangles());
    mute.clear();
    awaitStreams(2);
}

std::size_t heapInUse()
{
    const auto heap = mallinfo2();
    return heap.uordblks + heap.hblkhd;
}

std::size_t openFiles()
{
    return static_cast<std::size_t>(std::distance(
        std::filesystem::directory_iterator("/proc/self/fd"),
        std::filesystem::directory_iterator()));
}

// A minute: with ISOFRONT_TEST_INTENSITY=60 or so.
TEST_F(Streamed, doesNotGrowHoweverManyComeAndGo)
{
    // What is pooled here and there; were but a fifth of the clients left over, at 0.6 MiB each, it
    // would be as much. More rounds by the dial of intensity tell of less.
    constexpr std::size_t kNoise = std::size_t{4} << 20U;
    start();
    auto generator = tests::random(23);
    const auto round = [&] {
        std::vector<std::unique_ptr<Viewer>> viewers;
        for (std::size_t i = 0; i < 4; ++i) {
            viewers.push_back(std::make_unique<Viewer>(server->port(), target));
            viewers[i]->client.looksForCracks = false;
            viewers[i]->greet(view);
        }
        for (std::size_t i = 0; i < 4; ++i) {
            if (tests::below(generator, 3) == 0)
                viewers[i].reset(); // vanishes
            else if (i % 2 == 0)
                viewers[i]->settle();
            else
                viewers[i]->socket.send(isovalueMessage(0.01 * double(tests::below(generator, 3))));
        }
        viewers.clear();
        awaitStreams(0);
    };
    for (int i = 0; i < 4; ++i)
        round();
    const std::size_t heap = heapInUse();
    const std::size_t files = openFiles();
    for (int i = 0; i < tests::trials(8); ++i)
        round();
    // what is left of the last clients goes in its own time
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
    while ((heapInUse() > heap + kNoise || openFiles() > files) &&
           std::chrono::steady_clock::now() < end)
        std::this_thread::yield();
    EXPECT_LE(heapInUse(), heap + kNoise);
    EXPECT_LE(openFiles(), files);
}

} // namespace
} // namespace isofront::server
