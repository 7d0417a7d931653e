#include "HttpServer.h"

#include "Asio.h"
#include "Connection.h"

#include <algorithm>
#include <condition_variable>
#include <mutex>
#include <thread>

namespace isofront::server {
namespace {

std::size_t workersOf(const Settings& settings)
{
    if (settings.workers != 0)
        return settings.workers;
    return std::size_t{2} * std::max(1U, std::thread::hardware_concurrency());
}

} // namespace

struct HttpServer::Implementation {
    Implementation(Service& itsService, std::filesystem::path uploads)
        : service(itsService), workers(workersOf(itsService.settings())),
          acceptor(context), shared{itsService, workers, std::move(uploads), stop.get_token(), {}}
    {
    }

    ~Implementation()
    {
        stop.request_stop();
        // First the thread that hands out work, then those that do it: so nothing is queued for
        // workers that have ended. What they return is queued for a context that is still there.
        guard.reset();
        context.stop();
        if (thread.joinable())
            thread.join();
        workers.join();
    }

    core::Result<void> listen()
    {
        const Settings& settings = service.settings();
        const std::string where = settings.host + ":" + std::to_string(settings.port);
        ErrorCode error;
        tcp::resolver resolver(context);
        const auto found = resolver.resolve(
            settings.host, std::to_string(settings.port), tcp::resolver::passive, error);
        if (error || found.empty())
            return core::failure(
                core::ErrorCode::usage,
                "host: '" + settings.host + "' is no address of this machine: " + error.message());
        const tcp::endpoint endpoint = found.begin()->endpoint();
        acceptor.open(endpoint.protocol(), error);
        if (!error)
            acceptor.set_option(net::socket_base::reuse_address(true), error);
        if (!error)
            acceptor.bind(endpoint, error);
        if (!error)
            acceptor.listen(net::socket_base::max_listen_connections, error);
        if (error)
            return core::failure(
                core::ErrorCode::inputOutput,
                where + ": can't listen there: " + error.message() +
                    " (choose another with --port; 0 takes any that is free)");
        port = acceptor.local_endpoint().port();
        net::co_spawn(context, accept(), net::detached);
        thread = std::thread([this] { context.run(); });
        return {};
    }

    net::awaitable<void> accept()
    {
        const std::size_t most = service.settings().connections;
        while (acceptor.is_open()) {
            ErrorCode error;
            if (shared.connections.size() >= most && turnedAway >= most) {
                // the system keeps those that come until they can be told that there are too many
                room.expires_at(net::steady_timer::time_point::max());
                co_await room.async_wait(net::redirect_error(net::use_awaitable, error));
                continue;
            }
            tcp::socket socket =
                co_await acceptor.async_accept(net::redirect_error(net::use_awaitable, error));
            if (!acceptor.is_open())
                co_return;
            if (error) {
                // out of descriptors, say: others will be closed
                service.log().write(LogLevel::warning, "accept failed", {{"why", error.message()}});
                net::steady_timer pause(context, std::chrono::milliseconds(100));
                co_await pause.async_wait(net::redirect_error(net::use_awaitable, error));
                continue;
            }
            const auto connection = std::make_shared<Connection>(std::move(socket), shared);
            if (shared.connections.size() < most) {
                const std::scoped_lock lock(mutex);
                shared.connections.insert(connection);
                net::co_spawn(context, hold(connection), net::detached);
                continue;
            }
            service.metrics().count(Metrics::Count::refused);
            net::co_spawn(context, turnAway(connection), net::detached);
        }
    }

    net::awaitable<void> hold(std::shared_ptr<Connection> connection)
    {
        try {
            const Counted counted(service.metrics(), Metrics::Level::connections);
            co_await connection->serve();
        } catch (const std::exception& error) {
            service.log().write(LogLevel::error, "connection failed", {{"why", error.what()}});
        }
        {
            const std::scoped_lock lock(mutex);
            shared.connections.erase(connection);
        }
        room.cancel();
        changed.notify_all();
    }

    net::awaitable<void> turnAway(std::shared_ptr<Connection> connection)
    {
        ++turnedAway;
        try {
            co_await connection->turnAway();
        } catch (const std::exception& error) {
            service.log().write(LogLevel::error, "connection failed", {{"why", error.what()}});
        }
        --turnedAway;
        room.cancel();
    }

    /// Each connection ends once it has done what it does.
    void endAll()
    {
        ErrorCode ignored;
        acceptor.close(ignored);
        room.cancel();
        shared.isEnding = true;
        for (const auto& connection : shared.connections)
            connection->end();
        isClosed = true;
        changed.notify_all();
    }

    Service& service;
    net::thread_pool workers; // goes after what waits for it
    net::io_context context{1};
    net::executor_work_guard<net::io_context::executor_type> guard = net::make_work_guard(context);
    tcp::acceptor acceptor;
    net::steady_timer room{context}; ///< for another connection, waited for
    std::stop_source stop;
    Connection::Shared shared;
    std::thread thread;
    std::uint16_t port = 0;
    std::size_t turnedAway = 0;
    std::mutex mutex; ///< of `connections` and `isClosed`, for those who wait for the last one
    std::condition_variable changed;
    bool isClosed = false;
};

HttpServer::HttpServer(std::unique_ptr<Implementation> implementation)
    : _implementation(std::move(implementation))
{
}

HttpServer::~HttpServer() = default;

core::Result<std::unique_ptr<HttpServer>>
HttpServer::start(Service& service, const std::filesystem::path& uploads)
{
    auto implementation = std::make_unique<Implementation>(service, uploads);
    if (const auto listening = implementation->listen(); !listening)
        return tl::unexpected(listening.error());
    return std::unique_ptr<HttpServer>(new HttpServer(std::move(implementation)));
}

std::uint16_t HttpServer::port() const
{
    return _implementation->port;
}

bool HttpServer::drain()
{
    Implementation& all = *_implementation;
    all.service.beginDraining();
    bool isDone = false;
    {
        std::unique_lock lock(all.mutex);
        net::post(all.context, [&all] {
            const std::scoped_lock inside(all.mutex);
            all.endAll();
        });
        isDone =
            all.changed.wait_for(lock, milliseconds(all.service.settings().drainSeconds), [&all] {
                return all.isClosed && all.shared.connections.empty();
            });
    }
    return isDone;
}

} // namespace isofront::server
