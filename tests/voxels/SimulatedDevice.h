#pragma once

#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/LevelTransition.h>

#include <gtest/gtest.h>

#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace isofront::tests {

/// A device that does what frames say as late as it may: uploads are written when a frame is handed
/// over, as a host writes to mapped memory; moves and draws happen when it is completed. Whatever
/// is freed, moved or overwritten too early is then seen as wrong bytes.
class SimulatedDevice {
public:
    SimulatedDevice(std::shared_ptr<const voxels::ChunkStore> store, std::uint64_t bytes)
        : _store(std::move(store)), _memory(bytes)
    {
    }

    void submit(
        std::uint64_t number,
        const voxels::ChunkFrame& frame,
        const voxels::ChunkStreamer& streamer)
    {
        Frame& kept = _frames.emplace_back();
        kept.number = number;
        kept.moves = frame.moves;
        kept.draws = frame.draws;
        std::uint64_t bytes = 0;
        for (const voxels::ChunkUpload& upload : frame.uploads) {
            ASSERT_LE(upload.offset + upload.data.size(), _memory.size());
            std::memcpy(_memory.data() + upload.offset, upload.data.data(), upload.data.size());
            bytes += upload.data.size();
        }
        EXPECT_EQ(bytes, frame.uploadBytes);
        EXPECT_LE(bytes, streamer.settings().uploadBytes);
        uploaded += bytes;
        moved += frame.moves.size();
    }
    void add(std::span<const voxels::ChunkDraw> draws)
    {
        _frames.back().draws.insert(_frames.back().draws.end(), draws.begin(), draws.end());
    }

    /// Carries out all frames up to one.
    void complete(std::uint64_t number, const voxels::ChunkStreamer& streamer)
    {
        for (; !_frames.empty() && _frames.front().number <= number; _frames.pop_front()) {
            for (const voxels::ChunkMove& move : _frames.front().moves) {
                const std::uint64_t apart =
                    move.from < move.to ? move.to - move.from : move.from - move.to;
                EXPECT_GE(apart, move.bytes) << "a move overlaps itself";
                std::memmove(_memory.data() + move.to, _memory.data() + move.from, move.bytes);
            }
            for (const voxels::ChunkDraw& draw : _frames.front().draws) {
                expectAt(
                    draw.offset,
                    draw.standIn == nullptr ? bytesOf(draw.key, streamer)
                                            : standInOf(draw.index, draw.key, streamer),
                    draw);
                if (!draw.fades)
                    continue;
                expectAt(draw.transitionOffset, transitionOf(draw.key), draw);
                expectAt(draw.parentOffset, bytesOf(draw.key.parent(), streamer), draw);
                ++faded;
            }
        }
    }

    std::uint64_t uploaded = 0; ///< [bytes]
    std::uint64_t moved = 0;    ///< chunks
    std::uint64_t faded = 0;    ///< draws of chunks on their way from their parents

private:
    struct Frame {
        std::uint64_t number = 0;
        std::vector<voxels::ChunkMove> moves;
        std::vector<voxels::ChunkDraw> draws;
    };

    void expectAt(
        std::uint64_t offset, const std::vector<std::byte>& bytes, const voxels::ChunkDraw& draw)
    {
        ASSERT_LE(offset + bytes.size(), _memory.size());
        ASSERT_EQ(std::memcmp(_memory.data() + offset, bytes.data(), bytes.size()), 0)
            << "level " << draw.key.level << " in frame " << _frames.front().number;
    }

    const std::vector<std::byte>& transitionOf(const voxels::ChunkKey& key)
    {
        std::vector<std::byte>& bytes = _transitions[key];
        if (bytes.empty()) {
            const voxels::TransitionNodes nodes =
                *voxels::transitionNodes(**_store->get(key), **_store->get(key.parent()));
            for (const auto* words : {&nodes.parents, &nodes.redundant}) {
                const auto raw = std::as_bytes(std::span(*words));
                bytes.insert(bytes.end(), raw.begin(), raw.end());
            }
        }
        return bytes;
    }

    const std::vector<std::byte>&
    bytesOf(const voxels::ChunkKey& key, const voxels::ChunkStreamer& streamer)
    {
        std::vector<std::byte>& bytes = _bytes[key];
        if (bytes.empty()) {
            const auto chunk = _store->get(key);
            const voxels::ChunkForm& form = streamer.settings().form;
            bytes.resize(form.bytes(voxels::entryOf(**chunk)));
            form.pack(**chunk, bytes);
        }
        return bytes;
    }

    /// Those voxels of a chunk that lie where a finer one does, closed towards its neighbours.
    const std::vector<std::byte>& standInOf(
        voxels::ChunkIndex index,
        const voxels::ChunkKey& key,
        const voxels::ChunkStreamer& streamer)
    {
        std::vector<std::byte>& bytes = _standIns[{index, key}];
        if (!bytes.empty())
            return bytes;
        const voxels::ChunkKey below = streamer.tree()[index].entry.key;
        const std::uint32_t shift = key.level - below.level;
        const std::uint32_t edge = voxels::kChunkEdge >> shift;
        const auto chunk = _store->get(key);
        voxels::Chunk part;
        part.key = key;
        const auto isIn = [&](std::uint32_t of, std::uint32_t chunkAt, std::uint32_t at) {
            return (chunkAt * voxels::kChunkEdge + at) / edge == of;
        };
        const auto isFirst = [&](std::uint32_t at) { return at % edge == 0; };
        const auto isLast = [&](std::uint32_t at) { return at % edge == edge - 1; };
        for (const voxels::Voxel& v : (*chunk)->voxels) {
            if (!isIn(below.x, key.x, v.x()) || !isIn(below.y, key.y, v.y()) ||
                !isIn(below.z, key.z, v.z()))
                continue;
            std::uint8_t faces = v.faces();
            using voxels::Face;
            for (const auto& [at, low, high] :
                 {std::tuple{v.x(), Face::lowX, Face::highX},
                  std::tuple{v.y(), Face::lowY, Face::highY},
                  std::tuple{v.z(), Face::lowZ, Face::highZ}}) {
                if (isFirst(at))
                    faces |= voxels::faceBit(low);
                if (isLast(at))
                    faces |= voxels::faceBit(high);
            }
            part.voxels.push_back({voxels::packPlace(v.x(), v.y(), v.z(), faces), v.normal});
        }
        EXPECT_LE(part.voxels.size(), streamer.tree()[index].entry.voxels);
        const voxels::ChunkForm& form = streamer.settings().form;
        bytes.resize(form.bytes(voxels::entryOf(part)));
        form.pack(part, bytes);
        return bytes;
    }

    std::shared_ptr<const voxels::ChunkStore> _store;
    std::vector<std::byte> _memory;
    std::deque<Frame> _frames;
    std::map<voxels::ChunkKey, std::vector<std::byte>> _bytes;
    std::map<voxels::ChunkKey, std::vector<std::byte>> _transitions;
    std::map<std::pair<voxels::ChunkIndex, voxels::ChunkKey>, std::vector<std::byte>> _standIns;
};

} // namespace isofront::tests
