#include "isofront/core/Jobs.h"

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#ifdef ISOFRONT_WITH_TBB
#include "jobs/TbbJobs.h"
#endif

namespace isofront::core {
namespace {

class InlineJobs final : public Jobs {
public:
    void submit(std::function<void()> job) override { job(); }
    void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
    {
        for (std::size_t i = 0; i < count; ++i)
            body(i);
    }
    void wait() override {}
    [[nodiscard]] std::size_t concurrency() const override { return 1; }
};

class ThreadJobs final : public Jobs {
public:
    explicit ThreadJobs(std::size_t threads)
    {
        for (std::size_t i = 0; i < threads; ++i)
            _threads.emplace_back([this](const std::stop_token& stop) { work(stop); });
    }
    ~ThreadJobs() override { ThreadJobs::wait(); }

    void submit(std::function<void()> job) override
    {
        {
            const std::lock_guard lock(_mutex);
            _queue.push_back(std::move(job));
            ++_unfinished;
        }
        _wake.notify_one();
    }

    void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
    {
        // Shared by value: a helper that comes late, after the caller has left, finds nothing to do
        // but must still be able to look.
        struct Loop {
            std::atomic<std::size_t> next{0};
            std::atomic<std::size_t> done{0};
            std::mutex mutex;
            std::condition_variable finished;
        };
        auto loop = std::make_shared<Loop>();
        const auto* bodyOfCaller = &body;
        const auto run = [loop, count, bodyOfCaller] {
            for (std::size_t i = loop->next++; i < count; i = loop->next++) {
                (*bodyOfCaller)(i);
                if (++loop->done == count) {
                    const std::lock_guard lock(loop->mutex);
                    loop->finished.notify_all();
                }
            }
        };
        for (std::size_t i = 1; i < std::min(count, _threads.size() + 1); ++i)
            submit(run);
        run();
        std::unique_lock lock(loop->mutex);
        loop->finished.wait(lock, [&] { return loop->done == count; });
    }

    void wait() override
    {
        std::unique_lock lock(_mutex);
        _idle.wait(lock, [this] { return _unfinished == 0; });
    }
    [[nodiscard]] std::size_t concurrency() const override { return _threads.size(); }

private:
    void work(const std::stop_token& stop)
    {
        std::unique_lock lock(_mutex);
        while (_wake.wait(lock, stop, [this] { return !_queue.empty(); })) {
            auto job = std::move(_queue.front());
            _queue.pop_front();
            lock.unlock();
            job();
            job = nullptr; // what the job holds is let go before it counts as finished
            lock.lock();
            if (--_unfinished == 0)
                _idle.notify_all();
        }
    }

    std::mutex _mutex;
    std::condition_variable_any _wake;
    std::condition_variable _idle;
    std::deque<std::function<void()>> _queue;
    std::size_t _unfinished = 0;
    std::vector<std::jthread> _threads; // last: they stop before what they use goes
};

} // namespace

std::unique_ptr<Jobs> makeJobs(JobsBackend backend, std::size_t threads)
{
    if (threads == 0)
        threads = std::max(1U, std::thread::hardware_concurrency());
    switch (backend) {
    case JobsBackend::inlined:
        return std::make_unique<InlineJobs>();
    case JobsBackend::automatic:
    case JobsBackend::tbb:
#ifdef ISOFRONT_WITH_TBB
        return makeTbbJobs(threads);
#else
        [[fallthrough]];
#endif
    case JobsBackend::threads:
        break;
    }
    return std::make_unique<ThreadJobs>(threads);
}

} // namespace isofront::core
