#pragma once

#include <glm/vec3.hpp>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isofront::bench {

/// A pinhole that looks at a scene.
struct WatchedView {
    glm::dvec3 eye{0.0};
    glm::dvec3 forward{0.0};
    glm::dvec3 up{0.0};
    int width = 1280;
    int height = 720;
    double fieldOfView = 1.0; ///< vertical [rad]
    double pixelError = 4.0;
};

/// A client of a stream (docs/protocol.md, version 1) that keeps nothing of what it is sent, but
/// when it came: as little of a machine as a client can take.
///
/// Thread: one at a time.
class StreamWatcher {
public:
    using Clock = std::chrono::steady_clock;

    /// What it has seen so far.
    struct Seen {
        std::uint64_t bytes = 0;        ///< of all messages
        std::uint64_t payloadBytes = 0; ///< of cells
        std::uint64_t triangles = 0;    ///< in them
        std::uint64_t transactions = 0;
        std::vector<double> steps; ///< from each change of view to the first step that heeds it [s]
        std::vector<double> wholes; ///< from each to a surface that lacks nothing of the latest [s]
    };

    /// Connects to a service on this machine and says hello. Waits for the answer to the handshake.
    /// @param target  path of a stream
    StreamWatcher(std::uint16_t port, const std::string& target);
    StreamWatcher(const StreamWatcher&) = delete;
    StreamWatcher& operator=(const StreamWatcher&) = delete;
    ~StreamWatcher();

    /// For poll; negative once the conversation is over.
    [[nodiscard]] int descriptor() const { return _socket; }
    void look(const WatchedView& view);
    /// Takes what has come in.
    void listen();
    /// Nothing is lacking of the last view.
    [[nodiscard]] bool isSettled() const { return _isSettled; }
    [[nodiscard]] const Seen& seen() const { return _seen; }
    /// Begins to count anew.
    void forget() { _seen = {}; }

private:
    void send(std::span<const std::byte> message);
    void take(std::span<const std::byte> message);
    void takeCells(std::span<const std::byte> message);
    void takeTransaction(std::span<const std::byte> message);
    void give(std::uint64_t credits);
    void end();

    int _socket = -1;
    std::vector<std::byte> _read;
    std::vector<Clock::time_point> _unanswered; ///< changes of view without any step
    std::vector<Clock::time_point> _unsettled;  ///< and without a whole surface
    std::uint64_t _used = 0;                    ///< of the credits
    bool _isSettled = false;
    Seen _seen;
};

} // namespace isofront::bench
