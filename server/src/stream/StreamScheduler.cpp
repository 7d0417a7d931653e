#include "StreamScheduler.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace isofront::server {
namespace {

/// Between two looks at what doesn't tell when it is there: short beside a picture.
constexpr std::chrono::milliseconds kPause{4};

} // namespace

StreamScheduler::StreamScheduler() : _thread([this](const std::stop_token& stop) { run(stop); }) {}

StreamScheduler::~StreamScheduler() = default;

void StreamScheduler::add(Task& task)
{
    const std::lock_guard lock(_mutex);
    _entries.push_back({&task, false});
}

void StreamScheduler::remove(Task& task)
{
    std::unique_lock lock(_mutex);
    _changed.wait(lock, [&] { return _current != &task; });
    std::erase_if(_entries, [&](const Entry& entry) { return entry.task == &task; });
}

void StreamScheduler::wake(Task& task)
{
    const std::lock_guard lock(_mutex);
    const auto entry = std::ranges::find(_entries, &task, &Entry::task);
    if (entry == _entries.end() || entry->isAwake)
        return;
    entry->isAwake = true;
    _changed.notify_all();
}

void StreamScheduler::doLater(std::function<void()> work)
{
    const std::lock_guard lock(_mutex);
    _later.push_back(std::move(work));
    _changed.notify_all();
}

void StreamScheduler::run(const std::stop_token& stop)
{
    std::unique_lock lock(_mutex);
    while (true) {
        const auto isThereWork = [this] {
            return !_later.empty() || std::ranges::any_of(_entries, &Entry::isAwake);
        };
        if (!_changed.wait(lock, stop, isThereWork))
            return; // asked to end, and nothing is left
        bool isBusy = false;
        while (!_later.empty()) {
            std::function<void()> work = std::move(_later.front());
            _later.pop_front();
            lock.unlock();
            work();
            work = nullptr;
            lock.lock();
        }
        // those that come or go meanwhile have their turn in the next round
        const std::size_t count = _entries.size();
        for (std::size_t i = 0; i < count && !_entries.empty(); ++i) {
            // the first goes to the end, so that all come up whoever leaves
            _entries.splice(_entries.end(), _entries, _entries.begin());
            Entry& entry = _entries.back();
            if (!entry.isAwake)
                continue;
            entry.isAwake = false;
            Task& task = *entry.task;
            _current = &task;
            lock.unlock();
            const Outcome outcome = task.advance();
            lock.lock();
            // it can't have been removed: that waits for `_current`
            entry.isAwake = entry.isAwake || outcome != Outcome::idle;
            isBusy = isBusy || outcome == Outcome::busy;
            _current = nullptr;
            _changed.notify_all();
        }
        if (!isBusy && isThereWork())
            _changed.wait_for(lock, kPause, [&] { return stop.stop_requested(); });
    }
}

} // namespace isofront::server
