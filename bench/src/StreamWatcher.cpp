#include "StreamWatcher.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <utility>

namespace isofront::bench {

namespace {

/// Out at once, at the beginning; more is given for what has been used [bytes].
constexpr std::uint64_t kCredits = std::uint64_t{8} << 20U;

template <typename Number>
void put(std::vector<std::byte>& bytes, Number number)
{
    const auto source = std::as_bytes(std::span(&number, 1));
    bytes.insert(bytes.end(), source.begin(), source.end());
}

template <typename Number>
Number numberAt(std::span<const std::byte> bytes, std::size_t at)
{
    Number number{};
    if (at + sizeof number <= bytes.size())
        std::memcpy(&number, bytes.data() + at, sizeof number);
    return number;
}

/// Seconds from each moment until now for those that are before `heeded`, which go.
void answer(
    std::vector<StreamWatcher::Clock::time_point>& moments,
    StreamWatcher::Clock::time_point heeded,
    StreamWatcher::Clock::time_point now,
    std::vector<double>& seconds)
{
    std::erase_if(moments, [&](const auto& moment) {
        if (moment > heeded)
            return false;
        seconds.push_back(std::chrono::duration<double>(now - moment).count());
        return true;
    });
}

} // namespace

StreamWatcher::StreamWatcher(std::uint16_t port, const std::string& target)
    : _socket(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0))
{
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const int on = 1;
    setsockopt(_socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    const timeval patience{10, 0};
    setsockopt(_socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    if (connect(_socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        end();
        return;
    }
    const std::string request =
        "GET " + target +
        " HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    ::send(_socket, request.data(), request.size(), MSG_NOSIGNAL);
    std::string answer;
    char byte = 0;
    while (!answer.ends_with("\r\n\r\n") && recv(_socket, &byte, 1, 0) == 1)
        answer += byte;
    if (answer.find(" 101 ") == std::string::npos) {
        end();
        return;
    }
    fcntl(_socket, F_SETFL, O_NONBLOCK);
    std::vector<std::byte> hello;
    put(hello, std::uint32_t{0x0101});
    put(hello, std::uint64_t{16} << 20U); // of a cache
    put(hello, std::uint32_t{0});
    send(hello);
    give(kCredits);
}

StreamWatcher::~StreamWatcher()
{
    end();
}

void StreamWatcher::end()
{
    if (_socket >= 0)
        close(std::exchange(_socket, -1));
}

void StreamWatcher::look(const WatchedView& view)
{
    std::vector<std::byte> message;
    put(message, std::uint32_t{2});
    put(message, std::int32_t{view.width});
    put(message, std::int32_t{view.height});
    for (const glm::dvec3& v : {view.eye, view.forward, view.up})
        for (const double number : {v.x, v.y, v.z})
            put(message, number);
    put(message, view.fieldOfView);
    put(message, view.pixelError);
    _isSettled = false;
    _unanswered.push_back(Clock::now());
    _unsettled.push_back(_unanswered.back());
    send(message);
}

void StreamWatcher::give(std::uint64_t credits)
{
    std::vector<std::byte> message;
    put(message, std::uint64_t{5});
    put(message, credits);
    send(message);
}

void StreamWatcher::send(std::span<const std::byte> message)
{
    if (_socket < 0)
        return;
    std::vector<std::byte> frame{std::byte{0x82}};
    if (message.size() < 126) {
        frame.push_back(static_cast<std::byte>(0x80U | message.size()));
    } else {
        frame.push_back(std::byte{0x80 | 126});
        frame.push_back(static_cast<std::byte>(message.size() >> 8U));
        frame.push_back(static_cast<std::byte>(message.size() & 0xffU));
    }
    frame.resize(frame.size() + 4); // a mask of zeros
    frame.insert(frame.end(), message.begin(), message.end());
    // messages are so short that a service which takes none for long is a service that fails
    if (::send(_socket, frame.data(), frame.size(), MSG_NOSIGNAL) !=
        static_cast<ssize_t>(frame.size()))
        end();
}

void StreamWatcher::listen()
{
    std::array<std::byte, 65536> piece;
    while (_socket >= 0) {
        const ssize_t count = recv(_socket, piece.data(), piece.size(), 0);
        if (count < 0 && (errno == EAGAIN || errno == EINTR))
            break;
        if (count <= 0) {
            end();
            break;
        }
        _read.insert(_read.end(), piece.begin(), piece.begin() + count);
    }
    std::size_t at = 0;
    while (_read.size() - at >= 2) {
        const std::span<const std::byte> left = std::span(_read).subspan(at);
        const auto opcode = static_cast<unsigned>(left[0]) & 0x0fU;
        std::uint64_t size = static_cast<unsigned>(left[1]) & 0x7fU;
        const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
        if (left.size() < 2 + more)
            break;
        if (more > 0)
            size = 0;
        for (std::size_t i = 0; i < more; ++i)
            size = size << 8U | static_cast<std::uint64_t>(left[2 + i]);
        if (left.size() < 2 + more + size)
            break;
        if (opcode == 2)
            take(left.subspan(2 + more, size));
        else if (opcode == 8)
            end();
        at += 2 + more + size;
    }
    _read.erase(_read.begin(), _read.begin() + static_cast<std::ptrdiff_t>(at));
}

void StreamWatcher::take(std::span<const std::byte> message)
{
    const auto type = numberAt<std::uint8_t>(message, 0);
    _seen.bytes += message.size();
    if (type == 0x82)
        takeCells(message);
    else if (type == 0x83)
        takeTransaction(message);
    else if (type != 0x81)
        end();
    if (type != 0x82 && type != 0x83)
        return;
    _used += message.size();
    if (_used > kCredits / 8)
        give(std::exchange(_used, 0));
}

void StreamWatcher::takeCells(std::span<const std::byte> message)
{
    std::size_t at = 8;
    for (auto count = numberAt<std::uint32_t>(message, 4); count > 0; --count) {
        const std::size_t size = numberAt<std::uint32_t>(message, at + 8);
        _seen.triangles += numberAt<std::uint32_t>(message, at + 12 + 20);
        _seen.payloadBytes += size;
        at += 12 + size;
    }
}

void StreamWatcher::takeTransaction(std::span<const std::byte> message)
{
    const auto flags = numberAt<std::uint8_t>(message, 1);
    if ((flags & 1U) == 0)
        return;
    const Clock::time_point now = Clock::now();
    ++_seen.transactions;
    // it heeds what the service had heard so long ago
    const auto heeded =
        now - std::chrono::duration_cast<Clock::duration>(
                  std::chrono::duration<double, std::milli>(numberAt<double>(message, 40)));
    answer(_unanswered, heeded, now, _seen.steps);
    if ((flags & 2U) != 0) {
        answer(_unsettled, heeded, now, _seen.wholes);
        _isSettled = _unsettled.empty();
    }
    std::vector<std::byte> acknowledgement;
    put(acknowledgement, std::uint64_t{6});
    put(acknowledgement, numberAt<std::uint64_t>(message, 16));
    send(acknowledgement);
}

} // namespace isofront::bench
