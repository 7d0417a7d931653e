#include "TbbJobs.h"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

namespace isofront::core {
namespace {

class TbbJobs final : public Jobs {
public:
    // Jobs that are handed over have one more slot than workers, reserved for a thread that waits
    // for them. In a loop the calling thread counts as one of the threads.
    explicit TbbJobs(std::size_t threads)
        : _threads(threads), _workers(tbb::global_control::max_allowed_parallelism, threads + 1),
          _arena(static_cast<int>(threads) + 1, 1), _loops(static_cast<int>(threads), 1)
    {
    }
    // task_group may throw from its destructor; our jobs do not, so there is nothing to throw
    ~TbbJobs() noexcept override { TbbJobs::wait(); }

    void submit(std::function<void()> job) override
    {
        // enqueue starts a worker even when no thread of ours waits in the arena; defer counts the
        // job in the group at once, so that wait() can't miss it
        _arena.enqueue(_group.defer([job = std::move(job)]() noexcept { job(); }));
    }
    void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
    {
        _loops.execute(
            [&] { tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { body(i); }); });
    }
    void wait() override
    {
        _arena.execute([this] { _group.wait(); });
    }
    [[nodiscard]] std::size_t concurrency() const override { return _threads; }

private:
    std::size_t _threads;
    tbb::global_control _workers; ///< or TBB stops at the number of cores
    tbb::task_arena _arena;
    tbb::task_arena _loops;
    tbb::task_group _group;
};

} // namespace

std::unique_ptr<Jobs> makeTbbJobs(std::size_t threads)
{
    return std::make_unique<TbbJobs>(threads);
}

} // namespace isofront::core
