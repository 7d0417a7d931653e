#pragma once

#include <isofront/voxels/ChunkStreamer.h>

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <vector>

namespace isofront::voxels {

/// Where a chunk's transition begins behind the chunk [bytes].
std::uint64_t transitionOffset(const ChunkForm& form, const ChunkEntry& entry);
/// What a transition takes [bytes].
std::uint64_t transitionBytes(const ChunkEntry& entry);

/// Reads chunks from a store in the background and gives them the form in which they lie on the
/// device, in the order in which they are wanted.
///
/// Thread: all members from any thread.
class ChunkLoader {
public:
    struct Loaded {
        ChunkIndex index = 0;
        std::shared_ptr<const std::vector<std::byte>> data; ///< null if there is nothing to show
        bool hasTransition = false; ///< its parent could be read, and contains it
        /// Why the chunk can't be used. Then the data is that of a stand-in (standInFor), made from
        /// the nearest chunk above it that can be read, if there is one.
        std::optional<core::Error> error;
        ChunkEntry standIn; ///< what it is, as a chunk of its own
    };

    /// @param tree         outlives the loader
    /// @param bytes        what each chunk takes once it is loaded; outlives the loader
    /// @param transitions  whether they come behind chunks that have a parent
    ChunkLoader(
        std::shared_ptr<const ChunkStore> store,
        const ChunkTree& tree,
        std::span<const std::uint64_t> bytes,
        ChunkForm form,
        bool transitions,
        std::shared_ptr<core::Jobs> jobs);
    ChunkLoader(const ChunkLoader&) = delete;
    ChunkLoader& operator=(const ChunkLoader&) = delete;
    /// Takes everything back and waits for what is running.
    ~ChunkLoader();

    /// What is to be loaded now, the most urgent first; all else is taken back. What is being
    /// read is not read again.
    /// @param room       for chunks that are loaded or being loaded, what can't be taken back
    ///                   included [bytes]: what would exceed it isn't begun
    /// @param mayExceed  one chunk may exceed it if there is no other
    void want(const std::vector<ChunkIndex>& chunks, std::uint64_t room, bool mayExceed);
    /// What has been loaded since the last call; it may include what was wanted before.
    std::vector<Loaded> take();
    /// Waits until there is something to take, or nothing that it could wait for.
    void wait();

private:
    void work();
    [[nodiscard]] bool hasRoom() const;
    [[nodiscard]] Loaded load(ChunkIndex index);
    /// As the directory says, or it is an error.
    [[nodiscard]] core::Result<Chunk> read(ChunkIndex index) const;
    /// A chunk above others. Null if it can't be read. Siblings come together: the last few stay.
    std::shared_ptr<const Chunk> parent(ChunkIndex index);
    void standIn(Loaded& loaded);
    bool addTransition(ChunkIndex index, const Chunk& chunk, std::span<std::byte> data);

    std::shared_ptr<const ChunkStore> _store;
    const ChunkTree& _tree;
    std::span<const std::uint64_t> _bytes;
    ChunkForm _form;
    bool _transitions;
    std::shared_ptr<core::Jobs> _jobs;
    std::mutex _mutex;
    std::condition_variable _changed; ///< something is loaded, or a worker has left
    std::deque<ChunkIndex> _wanted;
    std::set<ChunkIndex> _running;
    std::vector<Loaded> _loaded;
    std::uint64_t _held = 0; ///< of what ran or was loaded at the last call of want, or since
    std::uint64_t _room = 0;
    bool _mayExceed = false;
    std::size_t _workers = 0;
    struct Parent {
        ChunkIndex index = 0;
        std::shared_ptr<const Chunk> chunk;
    };
    std::deque<Parent> _parents; ///< read last, last
};

} // namespace isofront::voxels
