#pragma once

#include "../Metrics.h"
#include "../scenes/SceneRegistry.h"
#include "SharedPayloads.h"
#include "Stream.h"
#include "StreamScheduler.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/server/Settings.h>
#include <isofront/surface/SharedCells.h>
#include <isofront/surface/Surface.h>

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

namespace isofront::server {

class StreamSession;

/// How clients' surfaces of a source are extracted: the same for all, so that they can share cells.
surface::SurfaceOptions streamedSurface(const sources::Source& source, const Settings& settings);

/// What the streams have in common: the jobs that extract for them, the thread that they have their
/// turns on, and the cells of each scene, which are extracted once for all who look at it.
///
/// Thread: any.
class StreamHub {
public:
    StreamHub(const Settings& settings, Metrics& metrics);
    StreamHub(const StreamHub&) = delete;
    StreamHub& operator=(const StreamHub&) = delete;
    /// Once all streams have gone.
    ~StreamHub();

    /// Errors: resourceLimit if there are as many streams, or as much of them, as may be.
    core::Result<std::unique_ptr<Stream>> open(std::shared_ptr<const OpenScene> scene);

private:
    struct Cells {
        std::shared_ptr<surface::SharedCells> shared;
        surface::SharedCells::Stats told; ///< to the metrics
        std::uint64_t lastUse = 0;
    };

    Cells& cellsOf(const std::string& scene); // these four holding the lock
    void divideMemory();
    void report();
    [[nodiscard]] std::uint64_t bytes() const;

    const Settings _settings;
    Metrics& _metrics;
    std::shared_ptr<core::Jobs> _jobs;
    const std::shared_ptr<SharedPayloads> _payloads;
    mutable std::mutex _mutex;
    std::map<std::string, Cells> _cells;
    std::set<const StreamSession*> _sessions;
    std::uint64_t _uses = 0;
    StreamScheduler _scheduler; // first to go: takes apart what sessions have left
};

} // namespace isofront::server
