#include "Interest.h"

#include <sys/socket.h>

#include <cerrno>

namespace isofront::server {
namespace {

bool isGone(int socket)
{
    char byte = 0;
    const ssize_t count = recv(socket, &byte, 1, MSG_PEEK | MSG_DONTWAIT);
    return count == 0 || (count < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

} // namespace

Interest::Interest(tcp::socket& socket, double seconds, const std::stop_token& isEnding)
    : _socket(socket), _stop(std::make_shared<std::stop_source>()),
      _timer(socket.get_executor(), milliseconds(seconds)), _ending(isEnding, Forward{*_stop})
{
    _timer.async_wait([stop = _stop](const ErrorCode& error) {
        if (!error)
            stop->request_stop();
    });
    // cancelled before the socket goes, so its number is still its own without an error
    _socket.async_wait(
        tcp::socket::wait_read,
        [stop = _stop, number = _socket.native_handle()](const ErrorCode& error) {
            if (!error && !stop->stop_requested() && isGone(number))
                stop->request_stop();
        });
}

Interest::~Interest()
{
    ErrorCode ignored;
    _socket.cancel(ignored);
}

} // namespace isofront::server
