#include "../StreamWatcher.h"
#include "Suites.h"

#include <isofront/server/Server.h>

#include <arpa/inet.h>
#include <glm/geometric.hpp>
#include <malloc.h>
#include <netinet/in.h>
#include <nlohmann/json.hpp>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr double kRate = 10;   ///< changes of view a second
constexpr double kTurn = 0.05; ///< of a viewer around what it looks at [rad/s]
/// How late an answer may be for a viewer to find it quick [s].
constexpr double kQuick = 0.2;
constexpr double kMiB = 1024.0 * 1024.0;

/// What a service answers to a request, which is its last on that connection.
std::string asked(std::uint16_t port, const std::string& request, const std::string& body)
{
    const int descriptor = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    std::string answer;
    if (connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
        const std::string text = request +
                                 " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n"
                                 "Content-Type: application/json\r\nContent-Length: " +
                                 std::to_string(body.size()) + "\r\n\r\n" + body;
        send(descriptor, text.data(), text.size(), MSG_NOSIGNAL);
        std::array<char, 4096> piece{};
        for (ssize_t count = 0; (count = recv(descriptor, piece.data(), piece.size(), 0)) > 0;)
            answer.append(piece.data(), static_cast<std::size_t>(count));
    }
    close(descriptor);
    const std::size_t head = answer.find("\r\n\r\n");
    return head == std::string::npos ? "" : answer.substr(head + 4);
}

/// A service for as long as this lives, with one scene.
class Studio {
public:
    Studio(const std::string& formula, std::size_t clients)
    {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "isofront-bench-XXXXXX").string();
        if (mkdtemp(pattern.data()) == nullptr)
            return;
        _folder = pattern;
        server::Settings settings;
        settings.port = 0;
        settings.data = _folder / "data";
        settings.logLevel = "error";
        settings.anonymous = {"read", "write", "admin"};
        settings.streams = static_cast<std::uint32_t>(clients);
        auto started = server::Server::start(settings);
        if (!started)
            return;
        _server = std::move(*started);
        prepare(formula);
    }
    Studio(const Studio&) = delete;
    Studio& operator=(const Studio&) = delete;
    ~Studio()
    {
        _server.reset();
        if (!_folder.empty())
            std::filesystem::remove_all(_folder);
    }

    [[nodiscard]] bool isReady() const { return !_stream.empty(); }
    [[nodiscard]] std::unique_ptr<StreamWatcher> watcher() const
    {
        return std::make_unique<StreamWatcher>(_server->port(), _stream);
    }
    /// Looks at the scene after a turn around it.
    [[nodiscard]] WatchedView view(double angle) const
    {
        const glm::dvec3 back = _eye - _target;
        // Rodrigues
        const glm::dvec3 turned = std::cos(angle) * back + std::sin(angle) * glm::cross(_up, back) +
                                  (1 - std::cos(angle)) * glm::dot(_up, back) * _up;
        WatchedView view;
        view.eye = _target + turned;
        view.forward = -turned;
        view.up = _up;
        return view;
    }

private:
    void prepare(const std::string& formula)
    {
        const std::uint16_t port = _server->port();
        const Json made = Json::parse(
            asked(port, "POST /v1/scenes", Json{{"formula", formula}}.dump()), nullptr, false);
        if (!made.contains("id"))
            return;
        const std::string path = "/v1/scenes/" + made.at("id").get<std::string>();
        Json scene;
        do {
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
            scene = Json::parse(asked(port, "GET " + path, ""), nullptr, false);
        } while (scene.value("state", "") == "preparing");
        if (scene.value("state", "") != "ready")
            return;
        const Json& look = scene.at("description").at("view");
        const auto vector = [&](const char* name) {
            const Json& of = look.at(name);
            return glm::dvec3(of.at(0), of.at(1), of.at(2));
        };
        _eye = vector("eye");
        _target = vector("target");
        _up = glm::normalize(vector("up"));
        _stream = path + "/stream";
    }

    std::filesystem::path _folder;
    std::unique_ptr<server::Server> _server;
    std::string _stream;
    glm::dvec3 _eye{0.0};
    glm::dvec3 _target{0.0};
    glm::dvec3 _up{0.0, 0.0, 1.0};
};

using Watchers = std::vector<std::unique_ptr<StreamWatcher>>;

/// Takes what comes in until a moment, or until there is something.
void listen(const Watchers& watchers, Clock::time_point until)
{
    std::vector<pollfd> polled;
    for (const auto& watcher : watchers)
        polled.push_back({watcher->descriptor(), POLLIN, 0});
    const auto left = std::chrono::duration_cast<std::chrono::microseconds>(until - Clock::now());
    const timespec patience{0, std::clamp<long>(left.count(), 0, 100'000) * 1000};
    if (ppoll(polled.data(), polled.size(), &patience, nullptr) > 0)
        for (std::size_t i = 0; i < watchers.size(); ++i)
            if (polled[i].revents != 0)
                watchers[i]->listen();
}

bool areAll(const Watchers& watchers, const std::function<bool(const StreamWatcher&)>& holds)
{
    return std::ranges::all_of(watchers, [&](const auto& watcher) { return holds(*watcher); });
}

double processorSeconds()
{
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

double heapInUse()
{
    const auto heap = mallinfo2();
    return static_cast<double>(heap.uordblks + heap.hblkhd);
}

/// The value that a share of all is no greater than.
double quantile(std::vector<double> values, double share)
{
    if (values.empty())
        return std::nan("");
    std::ranges::sort(values);
    const auto at = static_cast<std::size_t>(share * static_cast<double>(values.size() - 1) + 0.5);
    return values[at];
}

struct Load {
    std::string formula;
    bool isTogether = false; ///< all look from one place, rather than from all around
    std::size_t clients = 1;
};

/// @return false if a client was lost, or never got its first view whole
bool measure(const Context& context, const Load& load, Table& table)
{
    const Studio studio(load.formula, load.clients);
    if (!studio.isReady())
        return false;
    const auto phase = [&](std::size_t i) {
        return load.isTogether ? 0.0
                               : 2 * std::numbers::pi * static_cast<double>(i) /
                                     static_cast<double>(load.clients);
    };
    const auto isThere = [](const StreamWatcher& watcher) { return watcher.descriptor() >= 0; };
    // the scene's field, and what there is but once, is there with the first client
    Watchers watchers;
    double heapOfOne = 0;
    double heapOfAll = 0;
    for (const bool isFirst : {true, false}) {
        while (watchers.size() < (isFirst ? 1 : load.clients)) {
            watchers.push_back(studio.watcher());
            watchers.back()->look(studio.view(phase(watchers.size() - 1)));
        }
        const auto end = Clock::now() + std::chrono::seconds(300);
        while (areAll(watchers, isThere) && !context.isStopped() && Clock::now() < end &&
               !areAll(watchers, [](const StreamWatcher& w) { return w.isSettled(); }))
            listen(watchers, Clock::now() + std::chrono::milliseconds(20));
        (isFirst ? heapOfOne : heapOfAll) = heapInUse();
    }
    if (!areAll(watchers, [](const StreamWatcher& w) { return w.isSettled(); }))
        return false;
    std::uint64_t bytes = 0;
    std::uint64_t payloadBytes = 0;
    std::uint64_t triangles = 0;
    const auto add = [&](const StreamWatcher::Seen& seen) {
        bytes += seen.bytes;
        payloadBytes += seen.payloadBytes;
        triangles += seen.triangles;
    };
    for (const auto& watcher : watchers) {
        add(watcher->seen());
        watcher->forget();
    }
    const double firstMiB = static_cast<double>(bytes) / kMiB / static_cast<double>(load.clients);
    const double perTriangle = static_cast<double>(bytes) / static_cast<double>(triangles);
    const double payloadPerTriangle =
        static_cast<double>(payloadBytes) / static_cast<double>(triangles);
    const double perClient = static_cast<double>(triangles) / static_cast<double>(load.clients);

    const auto begin = Clock::now();
    const double processor = processorSeconds();
    const auto after = [&](double seconds) {
        return begin +
               std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    };
    const double duration = context.pick(0.5, 5.0);
    // one after the other, evenly
    const double pause = 1 / kRate / static_cast<double>(load.clients);
    const auto changes = static_cast<std::size_t>(duration * kRate) * load.clients;
    double late = 0;
    for (std::size_t i = 0; i < changes && !context.isStopped(); ++i) {
        const double due = static_cast<double>(i) * pause;
        do
            listen(watchers, after(due));
        while (Clock::now() < after(due));
        late = std::max(late, std::chrono::duration<double>(Clock::now() - after(due)).count());
        watchers[i % load.clients]->look(
            studio.view(phase(i % load.clients) + kTurn * (due + 1 / kRate)));
    }
    const double lasted = std::chrono::duration<double>(Clock::now() - begin).count();
    const double busy = (processorSeconds() - processor) / lasted;
    const auto end = Clock::now() + std::chrono::seconds(60);
    while (areAll(watchers, isThere) && !context.isStopped() && Clock::now() < end &&
           !areAll(watchers, [](const StreamWatcher& w) { return w.isSettled(); }))
        listen(watchers, Clock::now() + std::chrono::milliseconds(20));
    std::vector<double> steps;
    std::vector<double> wholes;
    bytes = 0;
    for (const auto& watcher : watchers) {
        const StreamWatcher::Seen& seen = watcher->seen();
        steps.insert(steps.end(), seen.steps.begin(), seen.steps.end());
        wholes.insert(wholes.end(), seen.wholes.begin(), seen.wholes.end());
        bytes += seen.bytes;
    }
    // what hasn't come within a minute may never
    for (auto* seconds : {&steps, &wholes})
        seconds->resize(changes, std::numeric_limits<double>::infinity());
    table.add(
        {load.formula,
         std::string(load.isTogether ? "the same" : "its own"),
         count(load.clients),
         quantile(steps, 0.5) * 1e3,
         quantile(steps, 0.99) * 1e3,
         quantile(wholes, 0.5) * 1e3,
         quantile(wholes, 0.99) * 1e3,
         late * 1e3,
         busy,
         perClient,
         firstMiB,
         static_cast<double>(bytes) / 1024 / lasted / static_cast<double>(load.clients),
         perTriangle,
         payloadPerTriangle,
         load.clients > 1 ? (heapOfAll - heapOfOne) / kMiB / static_cast<double>(load.clients - 1)
                          : std::nan("")});
    return areAll(watchers, isThere);
}

} // namespace

SuiteResult runClients(const Context& context)
{
    SuiteResult result;
    Table table{
        "clients",
        "Clients that change their view ten times a second",
        {{"scene", "", "what they look at"},
         {"path", "", "where each flies: around the scene, from the same place or from its own"},
         {"clients", "", "at once, on the same machine as the service"},
         {"step_p50", "ms", "from a change of view to the first step that heeds it"},
         {"step_p99", "ms", "the same"},
         {"whole_p50", "ms", "from a change of view to a surface that lacks nothing of the latest"},
         {"whole_p99", "ms", "the same"},
         {"late", "ms", "the most that a view was sent too late by, for want of a processor"},
         {"cores", "", "busy, with the service and with its clients"},
         {"triangles", "", "sent to a client for its first view"},
         {"first", "MiB", "sent to a client for its first view"},
         {"rate", "KiB/s", "sent to a client that moves"},
         {"per_triangle", "B", "sent, all messages together"},
         {"payload", "B", "of payloads, for a triangle"},
         {"memory", "MiB", "that the service's heap grows by for another client"}},
        {},
        {}};
    for (const char* path : {"the same", "its own"}) {
        Plot plot;
        plot.name = std::string("whole, path ") + path;
        std::ranges::replace(plot.name, ' ', '-');
        plot.title = std::string("until the surface is whole, path: ") + path;
        plot.x = "clients";
        plot.y = "whole_p99";
        plot.series = "scene";
        plot.whereColumn = "path";
        plot.whereWord = path;
        plot.isLogarithmicX = plot.isLogarithmicY = true;
        table.plots.push_back(plot);
    }
    const std::vector<std::size_t> counts =
        context.isFull() ? std::vector<std::size_t>{1, 10, 50} : std::vector<std::size_t>{1, 4};
    std::vector<const char*> formulas{"proc:gyroid"};
    if (context.isFull())
        formulas.push_back("proc:terrain");
    for (const char* formula : formulas)
        for (const bool isTogether : {true, false}) {
            std::size_t most = 0;
            std::size_t mostWhole = 0;
            for (const std::size_t clients : counts) {
                if (context.isStopped())
                    return result;
                context.say(std::string(formula) + ", clients: " + std::to_string(clients));
                const bool isServed = measure(context, {formula, isTogether, clients}, table);
                if (context.isStopped())
                    return result;
                result.check(
                    "No client is lost",
                    isServed,
                    std::string(formula) + ", clients: " + std::to_string(clients));
                const std::size_t last = table.rows.size() - 1;
                if (isServed && table.number(last, "whole_p99") < 1e3 * kQuick)
                    mostWhole = clients;
                // with more it only gets later
                if (!isServed || table.number(last, "step_p99") >= 1e3 * kQuick)
                    break;
                most = clients;
            }
            result.notes.push_back(
                std::string(formula) + ", " + (isTogether ? "one path" : "paths of their own") +
                ": 99 of 100 changes of view lead to a step within 200 ms with " +
                std::to_string(most) + " clients, to a whole surface with " +
                std::to_string(mostWhole) + ".");
        }
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench
