#pragma once

#include <isofront/voxels/ChunkStreamer.h>

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

namespace isofront::voxels {

/// Rounded up to what a chunk takes in the cache [bytes].
constexpr std::uint64_t alignedBytes(std::uint64_t bytes)
{
    return (bytes + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
}

/// Places for chunks in one range of the device's memory. Knows no contents: it says what lies
/// where, and never gives away a range that a frame under way may still read.
///
/// The end of the range is set aside for defragmentation. There, chunks that are in the way wait
/// until the frames that read their old places are done, and then move down to close the gaps. So
/// all free space can always be made one, whatever the sizes are.
///
/// Thread: one at a time.
class DeviceCache {
public:
    /// @param capacity  of the device's memory [bytes]
    /// @param root      what the first chunk takes; there is always room for it [bytes]
    /// @param largest   chunk that will ever be put in [bytes]
    DeviceCache(std::uint64_t capacity, std::uint64_t root, std::uint64_t largest);

    /// What chunks can take together; the rest is set aside [bytes].
    [[nodiscard]] std::uint64_t usable() const { return _usable; }
    /// What they take now [bytes].
    [[nodiscard]] std::uint64_t used() const { return _used; }
    /// Ranges that were given up, but that frames under way may read [bytes].
    [[nodiscard]] std::uint64_t pending() const { return _pendingBytes; }

    /// Begins a frame: what only frames up to `completed` have read is free.
    void begin(std::uint64_t frame, std::uint64_t completed);

    /// A place for a chunk, multiple of kChunkAlignment; nothing if no range that is free is long
    /// enough.
    std::optional<std::uint64_t> allocate(ChunkIndex index, std::uint64_t bytes);
    /// Gives up a chunk's place. It is free when the frame that used it last is complete.
    void release(ChunkIndex index);
    /// The chunk is read or written for this frame.
    void use(ChunkIndex index) { _places.at(index).lastUse = _frame; }
    [[nodiscard]] bool contains(ChunkIndex index) const { return _places.contains(index); }
    [[nodiscard]] std::uint64_t offsetOf(ChunkIndex index) const
    {
        return _places.at(index).offset;
    }

    /// Asks for defragmentation until a range of so many bytes is free [bytes].
    void makeRoom(std::uint64_t bytes);
    [[nodiscard]] bool isDefragmenting() const { return _isDefragmenting; }
    /// The next steps of defragmentation, if it was asked for; each chunk at most once.
    /// @param mostBytes  at most so much, or one chunk
    /// @param pinned     a chunk that must stay where it is; kNoChunk for none
    std::vector<ChunkMove> move(std::uint64_t mostBytes, ChunkIndex pinned);

private:
    struct Place {
        std::uint64_t offset = 0;
        std::uint64_t bytes = 0;
        std::uint64_t lastUse = 0; ///< frame
    };
    struct Pending {
        std::uint64_t offset = 0;
        std::uint64_t bytes = 0;
        std::uint64_t frame = 0; ///< free when it is complete
    };

    [[nodiscard]] bool isFree(std::uint64_t offset, std::uint64_t bytes) const;
    [[nodiscard]] std::uint64_t longestFree() const;
    void takeFree(std::uint64_t offset, std::uint64_t bytes);
    void giveFree(std::uint64_t offset, std::uint64_t bytes);
    void retire(std::uint64_t offset, std::uint64_t bytes, std::uint64_t lastUse);
    ChunkMove moved(ChunkIndex index, std::uint64_t to);

    std::uint64_t _usable = 0;
    std::uint64_t _capacity = 0;
    std::uint64_t _used = 0;
    std::uint64_t _pendingBytes = 0;
    std::uint64_t _frame = 0;
    std::uint64_t _completed = 0;
    std::map<ChunkIndex, Place> _places;
    std::map<std::uint64_t, ChunkIndex> _byOffset;
    std::map<std::uint64_t, std::uint64_t> _free; ///< lengths of free ranges, by where they begin
    std::vector<Pending> _pending;

    bool _isDefragmenting = false;
    std::uint64_t _roomWanted = 0;
    std::uint64_t _packed = 0;        ///< everything below is packed
    std::uint64_t _gapEnd = 0;        ///< up to here nothing may be allocated meanwhile
    std::vector<ChunkIndex> _waiting; ///< moved out of the way, in the order of their old places
};

} // namespace isofront::voxels
