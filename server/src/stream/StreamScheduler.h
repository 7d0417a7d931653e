#pragma once

#include <condition_variable>
#include <cstddef>
#include <functional>
#include <list>
#include <mutex>
#include <thread>

namespace isofront::server {

/// Gives all who have something to do their turn, on one thread.
///
/// Thread: any.
class StreamScheduler {
public:
    enum class Outcome {
        idle,    ///< nothing more until it is woken
        waiting, ///< for something that doesn't tell when it is there
        busy,    ///< more to do
    };
    class Task {
    public:
        Task() = default;
        Task(const Task&) = delete;
        Task& operator=(const Task&) = delete;
        virtual ~Task() = default;
        /// A turn, of a few milliseconds.
        virtual Outcome advance() = 0;
    };

    StreamScheduler();
    StreamScheduler(const StreamScheduler&) = delete;
    StreamScheduler& operator=(const StreamScheduler&) = delete;
    /// Once no task is left.
    ~StreamScheduler();

    void add(Task& task);
    /// Waits while the task has its turn; it has none afterwards.
    void remove(Task& task);
    void wake(Task& task);
    /// Has something done on the thread that the turns are on, when there is time.
    void doLater(std::function<void()> work);

private:
    struct Entry {
        Task* task = nullptr;
        bool isAwake = false;
    };

    void run(const std::stop_token& stop);

    std::mutex _mutex;
    std::condition_variable_any _changed;
    std::list<Entry> _entries;
    std::list<std::function<void()>> _later;
    Task* _current = nullptr;
    std::jthread _thread; // ends first
};

} // namespace isofront::server
