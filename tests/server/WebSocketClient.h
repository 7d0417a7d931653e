#pragma once

#include "HttpClient.h"

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {

/// A WebSocket over a plain socket: RFC 6455 as far as it is needed here.
class WebSocketClient {
public:
    struct Frame {
        int opcode = 0; ///< 2: binary, 8: close
        std::string content;

        [[nodiscard]] std::span<const std::byte> bytes() const
        {
            return std::as_bytes(std::span(content));
        }
        /// Of a frame that closes.
        [[nodiscard]] int closeCode() const { return content.size() < 2 ? 0 : at(0) * 256 + at(1); }

    private:
        [[nodiscard]] int at(std::size_t i) const { return static_cast<unsigned char>(content[i]); }
    };

    WebSocketClient(std::uint16_t port, const std::string& target, const std::string& headers = "")
        : _http(port)
    {
        handshake = _http.ask(
            "GET",
            target,
            "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
            "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n" +
                headers);
    }

    bool send(std::span<const std::byte> message, int opcode = 2) const
    {
        std::string frame{static_cast<char>(0x80 | opcode)};
        const std::size_t size = message.size();
        if (size < 126) {
            frame += static_cast<char>(0x80U | size);
        } else {
            frame += static_cast<char>(0x80 | 127);
            for (int shift = 56; shift >= 0; shift -= 8)
                frame += static_cast<char>(std::uint64_t{size} >> shift & 0xffU);
        }
        const char mask[] = {0x12, 0x55, 0x03, 0x7a};
        frame.append(mask, 4);
        for (std::size_t i = 0; i < size; ++i)
            frame += static_cast<char>(static_cast<char>(message[i]) ^ mask[i % 4]);
        return _http.send(frame);
    }

    /// Sends bytes that may be no frame.
    bool sendRaw(std::string_view bytes) const { return _http.send(bytes); }
    /// Hangs up without a word.
    void hangUp() const { _http.hangUp(); }
    /// True once the other side has closed, and all that it had sent has been read.
    bool isClosed() { return _http.isClosed(); }

    /// The next frame, pings aside; nothing if the other side has gone.
    std::optional<Frame> receive()
    {
        while (true) {
            const auto head = _http.read(2);
            if (!head)
                return std::nullopt;
            std::uint64_t size = static_cast<unsigned char>((*head)[1]) & 0x7fU;
            const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
            if (more > 0) {
                const auto length = _http.read(more);
                if (!length)
                    return std::nullopt;
                size = 0;
                for (const char byte : *length)
                    size = size << 8U | static_cast<unsigned char>(byte);
            }
            const auto content = _http.read(size);
            if (!content)
                return std::nullopt;
            const int opcode = (*head)[0] & 0x0f;
            if (opcode != 9)
                return Frame{opcode, *content};
            send(std::as_bytes(std::span(*content)), 10);
        }
    }

    HttpAnswer handshake;

private:
    HttpClient _http;
};

} // namespace isofront::server
