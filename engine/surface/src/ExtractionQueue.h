#pragma once

#include "CellCache.h"
#include "isofront/surface/SharedCells.h"

#include <isofront/core/Jobs.h>
#include <isofront/extractor/CellExtractor.h>

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <queue>
#include <unordered_map>
#include <vector>

namespace isofront::surface {

/// Extracts cells in the background, the most urgent first. Which one that is, is decided when a
/// worker becomes free, so that a request can be overtaken, made more urgent, or taken back.
///
/// Thread: all members from any thread. What is finished waits here until somebody takes it.
class ExtractionQueue {
public:
    ExtractionQueue(
        std::shared_ptr<const extractor::CellExtractor> extractor,
        std::shared_ptr<core::Jobs> jobs,
        std::shared_ptr<SharedCells> shared = nullptr);
    ExtractionQueue(const ExtractionQueue&) = delete;
    ExtractionQueue& operator=(const ExtractionQueue&) = delete;
    /// Takes everything back and waits for what is running.
    ~ExtractionQueue();

    struct Request {
        hierarchy::CellId id;
        double urgency = 0;
    };
    struct Finished {
        hierarchy::CellId id;
        CellMeshPointer mesh;
    };

    /// Asks for cells, or changes how urgent they are if they were asked for already.
    void request(const std::vector<Request>& requests);
    /// Takes requests back. Work that has begun on them is abandoned at the next step.
    void cancel(const std::vector<hierarchy::CellId>& ids);
    std::vector<Finished> takeFinished();
    /// Forgets everything, what is finished included, and goes on with another extractor. Doesn't
    /// wait for what is running, which is abandoned.
    void restart(std::shared_ptr<const extractor::CellExtractor> extractor);
    /// Requested and not finished.
    [[nodiscard]] std::size_t pending() const;

private:
    struct Entry {
        double urgency = 0;
        bool running = false;
        bool wanted = true;
        std::shared_ptr<std::atomic<bool>> cancelled;
    };
    struct Queued {
        double urgency;
        hierarchy::CellId id;

        bool operator<(const Queued& other) const { return urgency < other.urgency; }
    };

    void work();
    void startWorkers();

    std::shared_ptr<const extractor::CellExtractor> _extractor;
    std::shared_ptr<core::Jobs> _jobs;
    std::shared_ptr<SharedCells> _shared;
    mutable std::mutex _mutex;
    std::condition_variable _workerLeft;
    std::unordered_map<hierarchy::CellId, Entry, hierarchy::CellIdHash> _entries;
    std::priority_queue<Queued> _queue; ///< entries that don't match `_entries` are stale
    std::vector<Finished> _finished;
    std::size_t _workers = 0;
    std::uint64_t _generation = 0; ///< counts the restarts
};

} // namespace isofront::surface
