#include "Connection.h"

#include "Interest.h"

#include <boost/beast/websocket/rfc6455.hpp>
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <limits>

namespace isofront::server {
namespace {

/// How much of a body that isn't wanted is read all the same, so that the client comes to read the
/// answer before its connection is reset [bytes].
constexpr std::size_t kMostDiscarded = std::size_t{4} << 20U;
constexpr double kDiscardSeconds = 2;
/// Of a body, in either direction [bytes/s].
constexpr double kLeastRate = 4096;
constexpr std::size_t kPiece = std::size_t{256} << 10U;

Method methodOf(http::verb verb)
{
    switch (verb) {
    case http::verb::get:
        return Method::get;
    case http::verb::head:
        return Method::head;
    case http::verb::post:
        return Method::post;
    case http::verb::put:
        return Method::put;
    case http::verb::delete_:
        return Method::remove;
    case http::verb::options:
        return Method::options;
    default:
        return Method::other;
    }
}

std::string textOf(beast::string_view text)
{
    return {text.data(), text.size()};
}

template <typename Fields>
void takeHeader(const Fields& from, Request& request)
{
    request.method = methodOf(from.method());
    request.target = textOf(from.target());
    for (const auto& field : from) {
        std::string name = textOf(field.name_string());
        for (char& c : name)
            c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
        std::string& value = request.headers[name];
        value += (value.empty() ? "" : ", ") + textOf(field.value());
    }
}

Response responseTo(const ErrorCode& error)
{
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
        return problem(431, "the header is longer than the service takes");
    if (error == http::error::body_limit)
        return problem(413, "the body is longer than the service takes");
    return problem(400, "that is no HTTP/1.1 request: " + error.message());
}

/// Whether the client has gone, so that nobody hears an answer.
bool isGone(const ErrorCode& error)
{
    return error == http::error::end_of_stream || error == http::error::partial_message ||
           error == net::error::eof || error == net::error::connection_reset ||
           error == net::error::broken_pipe || error == net::error::operation_aborted ||
           error == net::error::bad_descriptor ||
           error == beast::error::timeout; // which closes the socket
}

/// The body of an upload on its way to the disk.
class UploadWriter {
public:
    explicit UploadWriter(const std::filesystem::path& folder)
    {
        static std::atomic<std::uint64_t> number = 0;
        const std::filesystem::path path =
            folder / (std::to_string(getpid()) + "-" + std::to_string(++number) + ".part");
        // for nobody else on this machine
        const int descriptor = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
        _file.reset(descriptor >= 0 ? fdopen(descriptor, "wb") : nullptr);
        if (_file)
            _uploaded = std::make_shared<UploadedFile>(path);
        else
            _error = errno;
    }

    void write(const std::vector<char>& bytes, std::size_t count)
    {
        if (_error == 0 && std::fwrite(bytes.data(), 1, count, _file.get()) != count)
            _error = errno;
    }

    /// The file, or the answer to the client.
    tl::expected<std::shared_ptr<UploadedFile>, Response> finish()
    {
        if (_error == 0 && std::fflush(_file.get()) != 0)
            _error = errno;
        if (_error == 0 && fsync(fileno(_file.get())) != 0)
            _error = errno;
        _file.reset();
        if (_error != 0)
            return tl::unexpected(problem(
                _error == ENOSPC || _error == EDQUOT ? 507 : 500,
                std::string("the upload can't be stored: ") + std::strerror(_error)));
        return std::move(_uploaded);
    }

    [[nodiscard]] bool failed() const { return _error != 0; }

private:
    struct Close {
        void operator()(std::FILE* file) const { std::fclose(file); }
    };
    std::shared_ptr<UploadedFile> _uploaded; // deleted after the file is closed
    std::unique_ptr<std::FILE, Close> _file;
    int _error = 0;
};

} // namespace

Connection::Connection(tcp::socket socket, Shared& shared)
    : _stream(std::move(socket)), _shared(shared), _service(shared.service),
      _buffer(shared.service.settings().headerBytes + kPiece)
{
    ErrorCode error;
    const tcp::endpoint peer = _stream.socket().remote_endpoint(error);
    if (!error)
        _peer = peer.address().to_string(error);
    _stream.socket().set_option(tcp::no_delay(true), error);
}

void Connection::end()
{
    _isLast = true;
    if (_conversation)
        _conversation->end();
    else if (_isIdle)
        _stream.close();
}

net::awaitable<void> Connection::serve()
{
    // GCC 12 makes a trap of a co_await behind &&
    while (!_isLast) {
        const bool isThere = co_await awaitRequest();
        if (!isThere)
            break;
        co_await exchange();
    }
    if (!_conversation)
        co_await closeGently();
}

net::awaitable<void> Connection::turnAway()
{
    Response response = problem(503, "too many connections at once: try again");
    response.headers.emplace_back("Retry-After", "1");
    _isLast = true;
    _isUnread = true;
    Request request;
    request.peer = _peer;
    expireAfter(kDiscardSeconds);
    co_await answer(request, nullptr, Clock::now(), std::move(response));
    co_await closeGently();
}

/// Whether somebody keeps the service waiting by a byte now and then.
bool Connection::isTooSlow(Clock::time_point begin, std::uint64_t bytes) const
{
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return seconds > _service.settings().idleSeconds + static_cast<double>(bytes) / kLeastRate;
}

/// @return whether there is one
net::awaitable<bool> Connection::awaitRequest()
{
    if (_buffer.size() != 0)
        co_return true;
    _isIdle = true;
    expireAfter(_service.settings().idleSeconds);
    ErrorCode error;
    const std::size_t count = co_await _stream.async_read_some(
        _buffer.prepare(4096), net::redirect_error(net::use_awaitable, error));
    _isIdle = false;
    _buffer.commit(count);
    co_return !error;
}

net::awaitable<void> Connection::exchange()
{
    const Clock::time_point begin = Clock::now();
    Request request;
    request.peer = _peer;
    request.stop = _shared.stop;
    Parser parser;
    parser.header_limit(static_cast<std::uint32_t>(_service.settings().headerBytes));
    parser.body_limit(std::numeric_limits<std::uint64_t>::max());
    expireAfter(_service.settings().headerSeconds);
    ErrorCode error;
    co_await http::async_read_header(
        _stream, _buffer, parser, net::redirect_error(net::use_awaitable, error));
    if (error) {
        _isLast = true;
        if (isGone(error))
            co_return;
        _isUnread = true;
        co_await answer(request, nullptr, begin, responseTo(error));
        co_return;
    }
    _version = parser.get().version();
    _isLast = _isLast || _shared.isEnding || !parser.get().keep_alive();
    takeHeader(parser.get(), request);
    // One request must not be two to somebody else: a coding that isn't understood may hide a body,
    // and of two names each may believe another.
    const bool isAmbiguous =
        (request.headers.contains("transfer-encoding") && (!parser.chunked() || _version < 11)) ||
        parser.get().count(http::field::host) > 1;
    if (isAmbiguous) {
        _isLast = true;
        _isUnread = true;
        co_await answer(
            request, nullptr, begin, problem(400, "the header can be understood in two ways"));
        co_return;
    }
    if (_version >= 11 && !request.headers.contains("host")) {
        _isLast = true;
        _isUnread = true;
        co_await answer(request, nullptr, begin, problem(400, "HTTP/1.1 asks for a field Host"));
        co_return;
    }
    const bool hasBody =
        !parser.is_done() && (parser.chunked() || parser.content_length().value_or(0) > 0);

    auto admitted = _service.admit(request);
    if (auto* refusal = std::get_if<Response>(&admitted)) {
        _isUnread = hasBody;
        _isLast = _isLast || hasBody;
        co_await answer(request, nullptr, begin, std::move(*refusal));
        co_return;
    }
    const Service::Admission& admission = std::get<Service::Admission>(admitted);
    const Route& route = *admission.route;
    if (route.open) {
        if (hasBody || _buffer.size() != 0)
            _isLast = _isUnread = true;
        co_await converse(parser, request, admission, begin);
        co_return;
    }
    std::optional<Response> response;
    if (route.expect)
        response = co_await runOn(
            _shared.workers.get_executor(), [&] { return _service.expect(request, admission); });
    if (hasBody && !response)
        response = co_await readBody(parser, admission.bodyLimit, request, route.body);
    if (response) {
        _isUnread = hasBody && !parser.is_done();
        _isLast = _isLast || _isUnread;
    } else {
        _stream.expires_never();
        // how the service fares is told however much there is to do
        if (route.scope != Scope::none)
            response = _service.refuseForLoad();
        if (!response) {
            const Counted active(_service.metrics(), Metrics::Level::requests);
            const Interest interest(
                _stream.socket(), _service.settings().requestSeconds, request.stop);
            request.stop = interest.token();
            response = co_await runOn(_shared.workers.get_executor(), [&] {
                return std::optional(_service.answer(request, admission));
            });
        }
    }
    co_await answer(request, &route, begin, std::move(*response));
}

/// @return the answer, if it isn't taken
net::awaitable<std::optional<Response>>
Connection::readBody(Parser& parser, std::uint64_t limit, Request& request, BodyKind kind)
{
    const auto tooLong = [&] {
        return problem(
            413,
            limit == 0 ? std::string("this takes no body")
                       : "the body is longer than the " + std::to_string(limit) +
                             " bytes that the service takes");
    };
    if (kind == BodyKind::none || parser.content_length().value_or(0) > limit)
        co_return tooLong();
    if (request.room && parser.content_length()) {
        if (auto full = request.room->extend(*parser.content_length()))
            co_return full;
    }
    if (request.header("expect") == "100-continue") {
        constexpr std::string_view kContinue = "HTTP/1.1 100 Continue\r\n\r\n";
        ErrorCode error;
        co_await net::async_write(
            _stream,
            net::buffer(kContinue.data(), kContinue.size()),
            net::redirect_error(net::use_awaitable, error));
    }
    std::optional<UploadWriter> upload;
    if (kind == BodyKind::file)
        upload.emplace(_shared.uploads);
    std::vector<char> piece(kPiece);
    parser.body_limit(limit);
    const Clock::time_point begin = Clock::now();
    std::uint64_t total = 0;
    while (!parser.is_done()) {
        if (isTooSlow(begin, total)) {
            _isLast = true;
            co_return problem(408, "the body comes in too slowly");
        }
        parser.get().body().data = piece.data();
        parser.get().body().size = piece.size();
        expireAfter(_service.settings().idleSeconds);
        ErrorCode error;
        co_await http::async_read_some(
            _stream, _buffer, parser, net::redirect_error(net::use_awaitable, error));
        if (error == http::error::body_limit)
            co_return tooLong();
        if (error && error != http::error::need_buffer) {
            _isLast = true;
            co_return isGone(error) ? problem(408, "the body never came to its end")
                                    : responseTo(error);
        }
        const std::size_t count = piece.size() - parser.get().body().size;
        total += count;
        _service.metrics().count(Metrics::Count::bytesReceived, static_cast<double>(count));
        if (request.room) {
            if (auto full = request.room->extend(total))
                co_return full;
        }
        if (upload)
            co_await runOn(_shared.workers.get_executor(), [&] {
                upload->write(piece, count);
                return true;
            });
        else
            request.body.append(piece.data(), count);
        if (upload && upload->failed())
            break;
    }
    if (upload) {
        auto file = co_await runOn(
            _shared.workers.get_executor(), [&] { return std::optional(upload->finish()); });
        if (!*file)
            co_return std::move(file->error());
        request.file = std::move(**file);
    }
    co_return std::nullopt;
}

net::awaitable<void> Connection::answer(
    const Request& request, const Route* route, Clock::time_point begin, Response response)
{
    _isLast = _isLast || _shared.isEnding;
    _service.finish(request, route, begin, response);
    co_await write(request, response);
}

net::awaitable<void> Connection::write(const Request& request, const Response& response)
{
    const std::string_view content = response.content();
    http::response<http::span_body<const char>> message;
    message.version(_version);
    message.result(static_cast<unsigned>(response.status));
    const std::string_view reason = reasonOf(response.status);
    message.reason({reason.data(), reason.size()});
    message.keep_alive(!_isLast);
    for (const auto& [name, value] : response.headers)
        message.insert(name, value);
    if (response.status != 204 && response.status != 304)
        message.content_length(content.size());
    if (request.method != Method::head)
        message.body() = beast::span<const char>(content.data(), content.size());
    http::response_serializer<http::span_body<const char>> serializer(message);
    serializer.split(request.method == Method::head);
    ErrorCode error;
    const Clock::time_point begin = Clock::now();
    std::uint64_t total = 0;
    while (!error && !serializer.is_done() && !isTooSlow(begin, total) &&
           !(request.method == Method::head && serializer.is_header_done())) {
        expireAfter(_service.settings().idleSeconds);
        const std::size_t count = co_await http::async_write_some(
            _stream, serializer, net::redirect_error(net::use_awaitable, error));
        total += count;
    }
    if (error || isTooSlow(begin, total))
        _isLast = true;
}

net::awaitable<void> Connection::converse(
    const Parser& parser,
    const Request& request,
    const Service::Admission& admission,
    Clock::time_point begin)
{
    Conversation::Request handshake(http::request_header<>(parser.get().base()));
    std::optional<Response> refusal;
    if (_isUnread)
        refusal = problem(400, "a WebSocket begins with a header alone");
    else if (!beast::websocket::is_upgrade(handshake))
        refusal = problem(426, "this speaks WebSocket").with("Upgrade", "websocket");
    if (refusal) {
        co_await answer(request, admission.route, begin, std::move(*refusal));
        co_return;
    }
    if (auto full = _service.refuseStream()) {
        co_await answer(request, admission.route, begin, std::move(*full));
        co_return;
    }
    const Counted counted(_service.metrics(), Metrics::Level::streams);
    using Opened = tl::expected<std::unique_ptr<Stream>, Response>;
    std::optional<Opened> opened = co_await runOn(_shared.workers.get_executor(), [&] {
        return std::optional<Opened>(_service.open(request, admission));
    });
    if (!*opened) {
        co_await answer(request, admission.route, begin, std::move(opened->error()));
        co_return;
    }
    Response upgraded;
    upgraded.status = 101;
    _service.finish(request, admission.route, begin, upgraded);
    _isLast = true;
    _conversation =
        Conversation::make(std::move(_stream), std::move(**opened), _service, _shared.workers);
    if (_shared.isEnding)
        _conversation->end();
    co_await _conversation->carry(std::move(handshake));
}

/// Lets the client read all of the answer: a socket that is closed while there is something to be
/// read resets the connection, and what was on its way is lost.
net::awaitable<void> Connection::closeGently()
{
    ErrorCode error;
    _stream.socket().shutdown(tcp::socket::shutdown_send, error);
    if (_isUnread && !error) {
        expireAfter(kDiscardSeconds);
        std::vector<char> ignored(kPiece);
        for (std::size_t total = 0; !error && total < kMostDiscarded;) {
            const std::size_t count = co_await _stream.async_read_some(
                net::buffer(ignored), net::redirect_error(net::use_awaitable, error));
            total += count;
        }
    }
    _stream.close();
}

} // namespace isofront::server
