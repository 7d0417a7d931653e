#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace isofront::server {

struct HttpAnswer {
    int status = 0;                             ///< 0: none came
    std::map<std::string, std::string> headers; ///< names in lower case
    std::string body;
};

/// A client that sends just the bytes it is told to, wrong ones included.
///
/// Waits ten seconds for what doesn't come.
class HttpClient {
public:
    explicit HttpClient(std::uint16_t port) : _socket(socket(AF_INET, SOCK_STREAM, 0))
    {
        sockaddr_in address{};
        address.sin_family = AF_INET;
        address.sin_port = htons(port);
        address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        const timeval patience{10, 0};
        setsockopt(_socket, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
        setsockopt(_socket, SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);
        _isOpen =
            connect(_socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
    }
    HttpClient(const HttpClient&) = delete;
    HttpClient& operator=(const HttpClient&) = delete;
    ~HttpClient() { close(_socket); }

    [[nodiscard]] bool isOpen() const { return _isOpen; }
    /// Hangs up: nothing is sent or received any more.
    void hangUp() const { shutdown(_socket, SHUT_RDWR); }

    /// @return whether all was taken
    bool send(std::string_view bytes) const
    {
        while (!bytes.empty()) {
            const ssize_t count = ::send(_socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
            if (count <= 0)
                return false;
            bytes.remove_prefix(static_cast<std::size_t>(count));
        }
        return true;
    }

    /// True once the other side has closed, and all that it had sent has been read.
    bool isClosed()
    {
        if (!_read.empty())
            return false;
        char byte = 0;
        const ssize_t count = recv(_socket, &byte, 1, 0);
        return count == 0 || (count < 0 && errno == ECONNRESET);
    }

    /// The next so many bytes; nothing if there are no more.
    std::optional<std::string> read(std::size_t count)
    {
        while (_read.size() < count)
            if (!receive())
                return std::nullopt;
        std::string bytes = _read.substr(0, count);
        _read.erase(0, count);
        return bytes;
    }

    /// The next answer; without a body if that of a HEAD.
    HttpAnswer answer(bool isOfHead = false)
    {
        HttpAnswer answer;
        std::size_t end = 0;
        while ((end = _read.find("\r\n\r\n")) == std::string::npos)
            if (!receive())
                return answer;
        const std::string head = _read.substr(0, end);
        _read.erase(0, end + 4);
        answer.status = std::stoi(head.substr(head.find(' ') + 1, 3));
        for (std::size_t begin = head.find("\r\n"); begin != std::string::npos;) {
            begin += 2;
            const std::size_t next = head.find("\r\n", begin);
            const std::string line = head.substr(begin, next - begin);
            const std::size_t colon = line.find(": ");
            std::string name = line.substr(0, colon);
            for (char& c : name)
                c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
            answer.headers[name] = line.substr(colon + 2);
            begin = next;
        }
        const auto length = answer.headers.find("content-length");
        const std::size_t wanted =
            isOfHead || length == answer.headers.end() ? 0 : std::stoul(length->second);
        while (_read.size() < wanted)
            if (!receive())
                return answer;
        answer.body = _read.substr(0, wanted);
        _read.erase(0, wanted);
        return answer;
    }

    /// Asks on this connection.
    HttpAnswer
    ask(const std::string& method,
        const std::string& target,
        const std::string& headers = "",
        const std::optional<std::string>& body = {})
    {
        std::string text = method + " " + target + " HTTP/1.1\r\nHost: localhost\r\n" + headers;
        if (body)
            text += "Content-Length: " + std::to_string(body->size()) + "\r\n";
        send(text + "\r\n" + body.value_or(""));
        return answer(method == "HEAD");
    }

private:
    bool receive()
    {
        char bytes[65536];
        const ssize_t count = recv(_socket, bytes, sizeof bytes, 0);
        if (count > 0)
            _read.append(bytes, static_cast<std::size_t>(count));
        return count > 0;
    }

    int _socket;
    bool _isOpen = false;
    std::string _read;
};

} // namespace isofront::server
