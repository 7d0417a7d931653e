#include "ExtractionQueue.h"

#include "Turns.h"

#include <isofront/hierarchy/Diamond.h>

#include <utility>

namespace isofront::surface {

namespace {

/// Cells that a worker extracts before others who share the jobs have their turn.
constexpr std::size_t kTurn = 4;

} // namespace

ExtractionQueue::ExtractionQueue(
    std::shared_ptr<const extractor::CellExtractor> extractor,
    std::shared_ptr<core::Jobs> jobs,
    std::shared_ptr<SharedCells> shared)
    : _extractor(std::move(extractor)), _jobs(std::move(jobs)), _shared(std::move(shared))
{
}

ExtractionQueue::~ExtractionQueue()
{
    std::unique_lock lock(_mutex);
    for (auto& [id, entry] : _entries) {
        entry.wanted = false;
        if (entry.cancelled)
            entry.cancelled->store(true, std::memory_order_relaxed);
    }
    _queue = {};
    _workerLeft.wait(lock, [this] { return _workers == 0; });
}

void ExtractionQueue::request(const std::vector<Request>& requests)
{
    {
        const std::lock_guard lock(_mutex);
        for (const Request& request : requests) {
            Entry& entry = _entries[request.id];
            entry.wanted = true;
            if (entry.running) {
                entry.cancelled->store(false, std::memory_order_relaxed);
                continue;
            }
            entry.urgency = request.urgency;
            _queue.push({request.urgency, request.id});
        }
        // stale entries are dropped when they come up; before they pile up, all of them
        if (_queue.size() > 1024 && _queue.size() > 4 * _entries.size()) {
            _queue = {};
            for (const auto& [id, entry] : _entries)
                if (entry.wanted && !entry.running)
                    _queue.push({entry.urgency, id});
        }
    }
    startWorkers();
}

void ExtractionQueue::cancel(const std::vector<hierarchy::CellId>& ids)
{
    const std::lock_guard lock(_mutex);
    for (const hierarchy::CellId& id : ids) {
        const auto found = _entries.find(id);
        if (found == _entries.end())
            continue;
        if (found->second.running) {
            found->second.wanted = false;
            found->second.cancelled->store(true, std::memory_order_relaxed);
        } else {
            _entries.erase(found);
        }
    }
}

std::vector<ExtractionQueue::Finished> ExtractionQueue::takeFinished()
{
    const std::lock_guard lock(_mutex);
    return std::exchange(_finished, {});
}

void ExtractionQueue::restart(std::shared_ptr<const extractor::CellExtractor> extractor)
{
    const std::lock_guard lock(_mutex);
    for (auto& [id, entry] : _entries)
        if (entry.cancelled)
            entry.cancelled->store(true, std::memory_order_relaxed);
    _entries.clear();
    _queue = {};
    _finished.clear();
    _extractor = std::move(extractor);
    ++_generation;
}

std::size_t ExtractionQueue::pending() const
{
    const std::lock_guard lock(_mutex);
    return _entries.size();
}

void ExtractionQueue::startWorkers()
{
    std::size_t starting = 0;
    {
        const std::lock_guard lock(_mutex);
        while (_workers < _jobs->concurrency() && _workers < _entries.size()) {
            ++_workers;
            ++starting;
        }
    }
    for (std::size_t i = 0; i < starting; ++i)
        _jobs->submit([this] { work(); });
}

void ExtractionQueue::work()
{
    std::unique_lock lock(_mutex);
    for (std::size_t extracted = 0; !_queue.empty();) {
        if (extracted == kTurn) {
            extracted = 0;
            // Once it is handed over this queue may be gone. Its jobs are not: they wait for this.
            core::Jobs& jobs = *_jobs;
            lock.unlock();
            if (handOver(jobs, [this] { work(); }))
                return;
            lock.lock();
            continue;
        }
        const Queued next = _queue.top();
        _queue.pop();
        const auto found = _entries.find(next.id);
        if (found == _entries.end() || found->second.running ||
            found->second.urgency != next.urgency)
            continue;
        found->second.running = true;
        found->second.cancelled = std::make_shared<std::atomic<bool>>(false);
        const std::shared_ptr<std::atomic<bool>> cancelled = found->second.cancelled;
        const std::shared_ptr<const extractor::CellExtractor> extractor = _extractor;
        const std::uint64_t generation = _generation;

        lock.unlock();
        CellMeshPointer mesh = extractShared(*extractor, _shared.get(), next.id, cancelled.get());
        lock.lock();
        ++extracted;
        if (generation != _generation)
            continue;

        Entry& entry = _entries.at(next.id);
        if (entry.wanted && !mesh) {
            // taken back, abandoned and asked for again, all while it ran
            entry.running = false;
            _queue.push({entry.urgency, next.id});
            continue;
        }
        if (entry.wanted)
            _finished.push_back({next.id, std::move(mesh)});
        _entries.erase(next.id);
    }
    --_workers;
    _workerLeft.notify_all();
}

} // namespace isofront::surface
