#pragma once

#include "Asio.h"

#include <memory>
#include <stop_token>

namespace isofront::server {

/// Watches, while a request is worked on, whether anybody still wants the answer: it asks for a
/// stop when the client hangs up, when that has taken too long, and when the service ends.
///
/// A client that closes its own direction only, as some do after their last request, has gone, too.
/// One that has sent more is not looked at any further.
///
/// Thread: that of the connections; the token's any.
class Interest {
public:
    /// @param isEnding  stopped when the service ends
    Interest(tcp::socket& socket, double seconds, const std::stop_token& isEnding);
    Interest(const Interest&) = delete;
    Interest& operator=(const Interest&) = delete;
    ~Interest();

    [[nodiscard]] std::stop_token token() const { return _stop->get_token(); }

private:
    struct Forward {
        std::stop_source& stop;
        void operator()() const { stop.request_stop(); }
    };

    tcp::socket& _socket;
    std::shared_ptr<std::stop_source> _stop; ///< kept by what is waited for
    net::steady_timer _timer;
    std::stop_callback<Forward> _ending;
};

} // namespace isofront::server
