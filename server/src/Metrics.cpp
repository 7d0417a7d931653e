#include "Metrics.h"

#include <isofront/core/Process.h>

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <array>
#include <utility>

namespace isofront::server {
namespace {

struct Described {
    const char* name;
    const char* help;
};

// in the order of Metrics::Level
constexpr std::array kLevels{
    Described{"isofront_connections", "Connections that are open."},
    Described{"isofront_requests_active", "Requests that are being answered."},
    Described{"isofront_streams", "Clients that see a scene change."},
    Described{"isofront_scenes_open", "Scenes whose field is in memory."},
    Described{"isofront_scene_bytes", "Memory of the fields of open scenes."},
    Described{"isofront_cell_bytes", "Memory of extracted cells that clients share."},
    Described{"isofront_stream_bytes", "Memory of all that clients see, those cells included."},
};

// in the order of Metrics::Count
constexpr std::array kCounts{
    Described{"isofront_sent_bytes_total", "Bytes of bodies and messages sent."},
    Described{"isofront_received_bytes_total", "Bytes of bodies and messages received."},
    Described{"isofront_refused_total", "Connections and requests refused for a limit."},
    Described{"isofront_cells_extracted_total", "Cells extracted for clients."},
    Described{"isofront_cells_shared_total", "Cells that another client had had extracted."},
    Described{"isofront_cells_sent_total", "Cells sent to clients."},
    Described{"isofront_transactions_total", "Steps of clients' surfaces."},
    Described{"isofront_superseded_total", "Cells no longer wanted before they were sent."},
};

const prometheus::Histogram::BucketBoundaries kSeconds{
    0.001, 0.005, 0.01, 0.025, 0.05, 0.1, 0.25, 0.5, 1, 2.5, 5, 10, 30};

} // namespace

struct Metrics::Families {
    prometheus::Registry registry;
    std::array<prometheus::Gauge*, kLevels.size()> levels{};
    std::array<prometheus::Counter*, kCounts.size()> counts{};
    prometheus::Family<prometheus::Counter>* requests = nullptr;
    prometheus::Family<prometheus::Histogram>* durations = nullptr;
    prometheus::Histogram* settled = nullptr;
    prometheus::Gauge* peak = nullptr;
};

Metrics::Metrics() : _families(std::make_unique<Families>())
{
    prometheus::Registry& registry = _families->registry;
    for (std::size_t i = 0; i < kLevels.size(); ++i)
        _families->levels[i] = &prometheus::BuildGauge()
                                    .Name(kLevels[i].name)
                                    .Help(kLevels[i].help)
                                    .Register(registry)
                                    .Add({});
    for (std::size_t i = 0; i < kCounts.size(); ++i)
        _families->counts[i] = &prometheus::BuildCounter()
                                    .Name(kCounts[i].name)
                                    .Help(kCounts[i].help)
                                    .Register(registry)
                                    .Add({});
    _families->requests = &prometheus::BuildCounter()
                               .Name("isofront_requests_total")
                               .Help("Requests answered.")
                               .Register(registry);
    _families->durations = &prometheus::BuildHistogram()
                                .Name("isofront_request_seconds")
                                .Help("Time from a whole request to its whole answer.")
                                .Register(registry);
    _families->settled = &prometheus::BuildHistogram()
                              .Name("isofront_settle_seconds")
                              .Help("Time from a change of view or isovalue to the whole surface.")
                              .Register(registry)
                              .Add({}, kSeconds);
    _families->peak = &prometheus::BuildGauge()
                           .Name("isofront_peak_resident_bytes")
                           .Help("The most memory that the process has held.")
                           .Register(registry)
                           .Add({});
}

Metrics::~Metrics() = default;

void Metrics::change(Level level, double by)
{
    _families->levels[static_cast<std::size_t>(level)]->Increment(by);
}

void Metrics::set(Level level, double value)
{
    _families->levels[static_cast<std::size_t>(level)]->Set(value);
}

double Metrics::value(Level level) const
{
    return _families->levels[static_cast<std::size_t>(level)]->Value();
}

void Metrics::count(Count count, double by)
{
    _families->counts[static_cast<std::size_t>(count)]->Increment(by);
}

void Metrics::answered(std::string_view method, std::string_view route, int status, double seconds)
{
    const prometheus::Labels labels{{"method", std::string(method)}, {"route", std::string(route)}};
    prometheus::Labels all = labels;
    all.emplace("status", std::to_string(status));
    _families->requests->Add(all).Increment();
    _families->durations->Add(labels, kSeconds).Observe(seconds);
}

void Metrics::settled(double seconds)
{
    _families->settled->Observe(seconds);
}

std::string Metrics::text() const
{
    _families->peak->Set(static_cast<double>(core::peakResidentBytes()));
    return prometheus::TextSerializer().Serialize(_families->registry.Collect());
}

} // namespace isofront::server
