#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace isofront::voxels {

/// One of its kind for each job that runs at once, made when needed and used again.
template <typename T>
class Pool {
public:
    /// Calls `body` with one that nobody else has.
    template <typename Body>
    void with(const Body& body)
    {
        std::unique_ptr<T> one;
        {
            const std::scoped_lock lock(_mutex);
            if (!_free.empty()) {
                one = std::move(_free.back());
                _free.pop_back();
            }
        }
        if (one == nullptr)
            one = std::make_unique<T>();
        body(*one);
        const std::scoped_lock lock(_mutex);
        _free.push_back(std::move(one));
    }

private:
    std::mutex _mutex;
    std::vector<std::unique_ptr<T>> _free;
};

} // namespace isofront::voxels
