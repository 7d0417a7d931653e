#pragma once

// clang-format off
#include <utility> // Boost 1.74 uses std::exchange without including it
// clang-format on
#include <boost/asio/associated_executor.hpp>
#include <boost/asio/async_result.hpp>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/detached.hpp>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/redirect_error.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/strand.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>

#include <chrono>
#include <cstdint>
#include <exception>

namespace isofront::server {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using tcp = boost::asio::ip::tcp;
using ErrorCode = boost::system::error_code;

/// Runs `work` elsewhere, and goes on here with what it returns or throws. That must be something
/// that can be made by default, and what `work` refers to must outlive it.
template <typename Executor, typename Work>
auto runOn(Executor executor, Work work)
{
    using Value = decltype(work());
    return net::async_initiate<const net::use_awaitable_t<>&, void(std::exception_ptr, Value)>(
        [](auto handler, Executor there, Work todo) {
            net::post(there, [handler = std::move(handler), todo = std::move(todo)]() mutable {
                std::exception_ptr thrown;
                Value value{};
                try {
                    value = todo();
                } catch (...) {
                    thrown = std::current_exception();
                }
                const auto here = net::get_associated_executor(handler);
                net::post(
                    here,
                    [handler = std::move(handler), thrown, value = std::move(value)]() mutable {
                        handler(thrown, std::move(value));
                    });
            });
        },
        net::use_awaitable,
        executor,
        std::move(work));
}

inline std::chrono::milliseconds milliseconds(double seconds)
{
    return std::chrono::milliseconds(static_cast<std::int64_t>(seconds * 1e3));
}

} // namespace isofront::server
