#include "StreamHub.h"

#include "LimitedJobs.h"
#include "StreamSession.h"

#include <isofront/hierarchy/Criterion.h>

#include <algorithm>
#include <utility>

namespace isofront::server {
namespace {

/// n: small enough for steps of a few kilobytes, large enough to be encoded well.
constexpr int kLattice = 8;
/// Scenes whose cells are kept while nobody looks, for who comes back.
constexpr std::size_t kMostScenes = 8;
// Of the memory that the service may have, half is the scenes'. Of the other half:
constexpr std::uint64_t kCellsShare = 4;     ///< cells are kept in a quarter of all,
constexpr std::uint64_t kPayloadsShare = 32; ///< what is sent of them in so much,
constexpr std::uint64_t kStreamsShare = 2;   ///< and together with what clients see it is no more

} // namespace

surface::SurfaceOptions streamedSurface(const sources::Source& source, const Settings& settings)
{
    surface::SurfaceOptions options;
    options.extraction.latticeSize = kLattice;
    options.extraction.isovalue = source.fieldIsovalue(source.defaultIsovalue);
    options.extraction.attributes = source.field->hasAttributes();
    if (source.voxel) {
        const int native = sources::levelForStep(*source.voxel / source.domain.edge, kLattice);
        options.maxLevel = std::min(native + source.levelsBelowVoxel, hierarchy::kMaxLevel);
        options.extraction.cornerRadius =
            2 * hierarchy::axisStep(native, kLattice) * source.domain.edge;
    }
    options.maxTriangles = settings.streamTriangles;
    options.maxBytes = settings.streamBytes;
    options.cacheBytes = settings.streamBytes / 4;
    options.coarseFirst = 3;
    return options;
}

StreamHub::StreamHub(const Settings& settings, Metrics& metrics)
    : _settings(settings), _metrics(metrics), _jobs(core::makeJobs()),
      _payloads(std::make_shared<SharedPayloads>(settings.memoryBytes / kPayloadsShare))
{
}

StreamHub::~StreamHub() = default;

core::Result<std::unique_ptr<Stream>> StreamHub::open(std::shared_ptr<const OpenScene> scene)
{
    const std::lock_guard lock(_mutex);
    if (_sessions.size() >= _settings.streams)
        return core::failure(
            core::ErrorCode::resourceLimit,
            "as many clients as may be see scenes already: try again");
    if (bytes() > _settings.memoryBytes / kStreamsShare)
        return core::failure(
            core::ErrorCode::resourceLimit,
            "other clients' surfaces take all the memory that the service may: try again");
    StreamSession::Setup setup;
    setup.surface = streamedSurface(scene->source, _settings);
    setup.surface.shared = cellsOf(scene->record.id).shared;
    setup.scene = std::move(scene);
    setup.jobs = std::make_shared<LimitedJobs>(_jobs, _settings.streamJobs);
    setup.payloads = _payloads;
    setup.scheduler = &_scheduler;
    setup.metrics = &_metrics;
    setup.report = [this] {
        const std::lock_guard itsLock(_mutex);
        report();
    };
    setup.end = [this](const StreamSession& session) {
        const std::lock_guard itsLock(_mutex);
        _sessions.erase(&session);
        report();
    };
    auto session = std::make_unique<StreamSession>(std::move(setup));
    _sessions.insert(session.get());
    return session;
}

StreamHub::Cells& StreamHub::cellsOf(const std::string& scene)
{
    Cells& cells = _cells[scene];
    cells.lastUse = ++_uses;
    if (!cells.shared)
        cells.shared = std::make_shared<surface::SharedCells>(0);
    while (_cells.size() > kMostScenes) {
        auto oldest = _cells.end();
        for (auto one = _cells.begin(); one != _cells.end(); ++one)
            if (one->second.shared.use_count() == 1 && one->first != scene &&
                (oldest == _cells.end() || one->second.lastUse < oldest->second.lastUse))
                oldest = one;
        if (oldest == _cells.end())
            break;
        _cells.erase(oldest);
    }
    divideMemory();
    return cells;
}

void StreamHub::divideMemory()
{
    for (auto& [id, cells] : _cells)
        cells.shared->setCapacity(_settings.memoryBytes / kCellsShare / _cells.size());
}

void StreamHub::report()
{
    std::size_t kept = 0;
    for (auto& [id, cells] : _cells) {
        const surface::SharedCells::Stats now = cells.shared->stats();
        _metrics.count(
            Metrics::Count::cellsExtracted,
            static_cast<double>(now.extracted - cells.told.extracted));
        _metrics.count(
            Metrics::Count::cellsShared, static_cast<double>(now.shared - cells.told.shared));
        cells.told = now;
        kept += now.bytes;
    }
    _metrics.set(Metrics::Level::cellBytes, static_cast<double>(kept));
    _metrics.set(Metrics::Level::streamBytes, static_cast<double>(bytes()));
}

/// Meshes count once, however many clients see them.
std::uint64_t StreamHub::bytes() const
{
    std::uint64_t bytes = _payloads->stats().bytes;
    for (const auto& [id, cells] : _cells)
        bytes += cells.shared->stats().liveBytes;
    for (const StreamSession* session : _sessions)
        bytes += session->bytes();
    return bytes;
}

} // namespace isofront::server
