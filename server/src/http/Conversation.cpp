#include "Conversation.h"

#include <boost/beast/websocket.hpp>

#include <optional>
#include <span>
#include <vector>

namespace isofront::server {
namespace {

namespace websocket = boost::beast::websocket;

constexpr std::string_view kProtocol = "isofront.v1";
/// A client's messages are views and lists of cells that it holds.
constexpr std::size_t kLongestMessage = std::size_t{1} << 20U;
/// How long a client has to agree that it is over.
constexpr std::chrono::seconds kClosing(2);

class WebSocketConversation final : public Conversation,
                                    public std::enable_shared_from_this<WebSocketConversation> {
public:
    WebSocketConversation(
        beast::tcp_stream&& socket,
        std::unique_ptr<Stream> stream,
        Service& service,
        net::thread_pool& workers)
        : _socket(std::move(socket)), _stream(std::move(stream)), _service(service),
          _turn(net::make_strand(workers)), _wake(_socket.get_executor()),
          _patience(_socket.get_executor())
    {
    }

    net::awaitable<void> carry(Request handshake) override
    {
        const auto self = shared_from_this();
        websocket::stream_base::timeout timeout{};
        timeout.handshake_timeout = milliseconds(_service.settings().headerSeconds);
        timeout.idle_timeout = milliseconds(_service.settings().idleSeconds);
        timeout.keep_alive_pings = true;
        beast::get_lowest_layer(_socket).expires_never();
        _socket.set_option(timeout);
        _socket.read_message_max(kLongestMessage);
        _socket.binary(true);
        _socket.auto_fragment(false);
        const auto offered = handshake[http::field::sec_websocket_protocol];
        if (std::string_view(offered.data(), offered.size()).find(kProtocol) !=
            std::string_view::npos)
            _socket.set_option(
                websocket::stream_base::decorator([](websocket::response_type& answer) {
                    answer.set(
                        http::field::sec_websocket_protocol,
                        beast::string_view(kProtocol.data(), kProtocol.size()));
                }));
        ErrorCode error;
        co_await _socket.async_accept(handshake, net::redirect_error(net::use_awaitable, error));
        if (error)
            co_return;
        _stream->whenReady([weak = weak_from_this(), executor = _socket.get_executor()] {
            net::post(executor, [weak] {
                if (const auto conversation = weak.lock())
                    conversation->wake();
            });
        });
        net::co_spawn(
            _socket.get_executor(), [self] { return self->read(); }, net::detached);
        try {
            co_await write();
        } catch (const std::exception& failed) {
            _service.log().write(LogLevel::error, "stream failed", {{"why", failed.what()}});
            abort();
        }
        _isEnding = true;
        co_await runOn(_turn, [this] {
            _stream->whenReady({});
            return true;
        });
    }

    void end() override
    {
        _isEnding = true;
        wake();
    }

private:
    void abort()
    {
        _isBroken = true;
        wake();
        beast::get_lowest_layer(_socket).close();
    }

    void wake()
    {
        _isWoken = true;
        _wake.cancel();
    }

    net::awaitable<void> read()
    {
        const auto self = shared_from_this();
        beast::flat_buffer message;
        ErrorCode error;
        while (!_isBroken) {
            co_await _socket.async_read(message, net::redirect_error(net::use_awaitable, error));
            if (error)
                break;
            _service.metrics().count(
                Metrics::Count::bytesReceived, static_cast<double>(message.size()));
            const std::span bytes(
                static_cast<const std::byte*>(message.data().data()), message.size());
            // what isn't binary is nothing that the protocol has
            try {
                co_await runOn(_turn, [this, bytes, isBinary = _socket.got_binary()] {
                    _stream->receive(isBinary ? bytes : std::span<const std::byte>());
                    return true;
                });
            } catch (const std::exception& failed) {
                _service.log().write(LogLevel::error, "stream failed", {{"why", failed.what()}});
                break;
            }
            message.consume(message.size());
            wake();
        }
        _isBroken = true;
        wake();
    }

    struct Turn {
        std::optional<std::vector<std::byte>> message;
        bool isOver = false;
    };

    net::awaitable<void> write()
    {
        ErrorCode error;
        while (!_isEnding && !_isBroken) {
            _isWoken = false;
            const Turn turn = co_await runOn(_turn, [this] {
                std::optional<std::vector<std::byte>> message = _stream->next();
                return Turn{std::move(message), _stream->isOver()};
            });
            if (turn.message) {
                // whoever sends and doesn't read would keep the connection for ever
                _patience.expires_after(milliseconds(_service.settings().idleSeconds));
                _patience.async_wait([weak = weak_from_this()](const ErrorCode& cancelled) {
                    const auto self = weak.lock();
                    if (!cancelled && self)
                        self->abort();
                });
                co_await _socket.async_write(
                    net::buffer(turn.message->data(), turn.message->size()),
                    net::redirect_error(net::use_awaitable, error));
                _patience.cancel();
                if (error)
                    break;
                _service.metrics().count(
                    Metrics::Count::bytesSent, static_cast<double>(turn.message->size()));
            } else if (turn.isOver) {
                break;
            } else if (!_isWoken) {
                _wake.expires_at(net::steady_timer::time_point::max());
                co_await _wake.async_wait(net::redirect_error(net::use_awaitable, error));
            }
        }
        if (!_isBroken) {
            websocket::stream_base::timeout timeout{};
            timeout.handshake_timeout = kClosing;
            timeout.idle_timeout = websocket::stream_base::none();
            _socket.set_option(timeout);
            const websocket::close_code code =
                _isEnding ? websocket::close_code::going_away : websocket::close_code::normal;
            co_await _socket.async_close(
                websocket::close_reason(code), net::redirect_error(net::use_awaitable, error));
        }
        beast::get_lowest_layer(_socket).close();
    }

    websocket::stream<beast::tcp_stream> _socket;
    std::unique_ptr<Stream> _stream;
    Service& _service;
    net::strand<net::thread_pool::executor_type> _turn; ///< one use of the stream at a time
    net::steady_timer _wake;
    net::steady_timer _patience; ///< with a client that doesn't read
    bool _isWoken = false;
    bool _isEnding = false; ///< the service wants to end it
    bool _isBroken = false; ///< nothing more can be sent
};

} // namespace

std::shared_ptr<Conversation> Conversation::make(
    beast::tcp_stream&& socket,
    std::unique_ptr<Stream> stream,
    Service& service,
    net::thread_pool& workers)
{
    return std::make_shared<WebSocketConversation>(
        std::move(socket), std::move(stream), service, workers);
}

} // namespace isofront::server
