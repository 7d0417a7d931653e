#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace isofront::server {

/// What the service counts, for those who watch over it.
///
/// Thread: any.
class Metrics {
public:
    /// A number of things that come and go.
    enum class Level {
        connections,
        requests,
        streams,
        openScenes,
        sceneBytes,
        cellBytes,
        streamBytes
    };
    /// A number that only grows.
    enum class Count {
        bytesSent,
        bytesReceived,
        refused,
        cellsExtracted,
        cellsShared,
        cellsSent,
        transactions,
        superseded,
    };

    Metrics();
    Metrics(const Metrics&) = delete;
    Metrics& operator=(const Metrics&) = delete;
    ~Metrics();

    void change(Level level, double by);
    void set(Level level, double value);
    void count(Count count, double by = 1);
    /// @param route  the pattern, never the path: there may be any number of those
    void answered(std::string_view method, std::string_view route, int status, double seconds);
    /// Seconds from a change of view or isovalue to the surface that it leads to being sent whole.
    void settled(double seconds);
    [[nodiscard]] double value(Level level) const;

    /// All of it, as Prometheus's text exposition format 0.0.4.
    [[nodiscard]] std::string text() const;

private:
    struct Families;
    std::unique_ptr<Families> _families;
};

/// One thing that is there for as long as this lives, whichever way that ends.
class Counted {
public:
    Counted(Metrics& metrics, Metrics::Level level) : _metrics(&metrics), _level(level)
    {
        metrics.change(level, 1);
    }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
    ~Counted() { _metrics->change(_level, -1); }

private:
    Metrics* _metrics;
    Metrics::Level _level;
};

} // namespace isofront::server
