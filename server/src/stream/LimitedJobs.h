#pragma once

#include <isofront/core/Jobs.h>

#include <algorithm>
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>

namespace isofront::server {

/// A share of jobs that many have in common: whoever spreads work over all that can run at once
/// takes no more than so many.
class LimitedJobs final : public core::Jobs {
public:
    LimitedJobs(std::shared_ptr<core::Jobs> jobs, std::size_t limit)
        : _jobs(std::move(jobs)),
          _concurrency(std::clamp<std::size_t>(limit, 1, _jobs->concurrency()))
    {
    }
    ~LimitedJobs() override { LimitedJobs::wait(); }

    void submit(std::function<void()> job) override
    {
        {
            const std::lock_guard lock(_mutex);
            ++_running;
        }
        _jobs->submit([this, job = std::move(job)]() mutable {
            job();
            job = nullptr; // what it holds goes before this may
            const std::lock_guard lock(_mutex);
            --_running;
            _ended.notify_all();
        });
    }
    void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
    {
        _jobs->parallelFor(count, body);
    }
    /// Waits for those handed over here.
    void wait() override
    {
        std::unique_lock lock(_mutex);
        _ended.wait(lock, [this] { return _running == 0; });
    }
    [[nodiscard]] std::size_t concurrency() const override { return _concurrency; }

private:
    std::shared_ptr<core::Jobs> _jobs;
    std::size_t _concurrency;
    std::mutex _mutex;
    std::condition_variable _ended;
    std::size_t _running = 0;
};

} // namespace isofront::server
