#pragma once

#include <isofront/voxels/ChunkStreamer.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <set>
#include <vector>

namespace isofront::voxels {

/// Reads chunks from a store in the background and gives them the form in which they lie on the
/// device, in the order in which they are wanted.
///
/// Thread: all members from any thread.
class ChunkLoader {
public:
    struct Loaded {
        ChunkIndex index = 0;
        /// Or why the chunk can't be used.
        core::Result<std::shared_ptr<const std::vector<std::byte>>> data;
    };

    /// @param tree  outlives the loader
    ChunkLoader(
        std::shared_ptr<const ChunkStore> store,
        const ChunkTree& tree,
        ChunkForm form,
        std::shared_ptr<core::Jobs> jobs);
    ChunkLoader(const ChunkLoader&) = delete;
    ChunkLoader& operator=(const ChunkLoader&) = delete;
    /// Takes everything back and waits for what is running.
    ~ChunkLoader();

    /// What is to be loaded now, the most urgent first; all else is taken back. What is being
    /// read is not read again.
    void want(const std::vector<ChunkIndex>& chunks);
    /// What has been loaded since the last call; it may include what was wanted before.
    std::vector<Loaded> take();
    /// Waits until there is something to take, or nothing that it could wait for.
    void wait();

private:
    void work();
    [[nodiscard]] core::Result<std::shared_ptr<const std::vector<std::byte>>>
    load(ChunkIndex index) const;

    std::shared_ptr<const ChunkStore> _store;
    const ChunkTree& _tree;
    ChunkForm _form;
    std::shared_ptr<core::Jobs> _jobs;
    std::mutex _mutex;
    std::condition_variable _changed; ///< something is loaded, or a worker has left
    std::deque<ChunkIndex> _wanted;
    std::set<ChunkIndex> _running;
    std::vector<Loaded> _loaded;
    std::size_t _workers = 0;
};

} // namespace isofront::voxels
