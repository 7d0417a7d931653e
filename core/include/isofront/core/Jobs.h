#pragma once

#include <cstddef>
#include <functional>
#include <memory>

namespace isofront::core {

/// Where work runs. The one seam between our code and a threading library.
///
/// Thread: any thread may submit, jobs included. Jobs never throw (asserted by termination).
class Jobs {
public:
    Jobs() = default;
    Jobs(const Jobs&) = delete;
    Jobs& operator=(const Jobs&) = delete;
    /// Waits for all submitted work.
    virtual ~Jobs() = default;

    /// Hands over a job, to run once, in no promised order.
    virtual void submit(std::function<void()> job) = 0;
    /// Runs `body(0) .. body(count - 1)`, in no promised order, and returns when all are done. The
    /// calling thread helps.
    virtual void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) = 0;
    /// Waits until everything that was submitted is done. Not to be called from a job.
    virtual void wait() = 0;
    /// How many jobs can run at once (at least 1).
    [[nodiscard]] virtual std::size_t concurrency() const = 0;
};

enum class JobsBackend {
    automatic, ///< oneTBB where it is built in, otherwise `threads`
    tbb,       ///< oneTBB's work-stealing arena
    threads,   ///< a plain pool of std::jthread, which ThreadSanitizer understands
    inlined,   ///< the caller's own thread, at once and in order: deterministic, for tests
};

/// @param threads  how many; 0 means one for each core. Ignored by `inlined`.
std::unique_ptr<Jobs>
makeJobs(JobsBackend backend = JobsBackend::automatic, std::size_t threads = 0);

} // namespace isofront::core
