#pragma once

#include <hwy/aligned_allocator.h>

#include <cstddef>
#include <memory>
#include <vector>

namespace isofront::fields::graph {

/// Room for points in a register: few enough that registers stay in a near cache.
inline constexpr std::size_t kBlock = 256;

/// The places at which a block is evaluated: in double, with how each differs over a box (three
/// extents) or changes with x, y and z (nine derivatives), and the filter radius.
struct FrameBlock {
    alignas(64) double at[3][kBlock];
    alignas(64) float change[9][kBlock];
    alignas(64) float radius[2][kBlock]; ///< least and most
};

/// Memory of a thread, lent to one evaluation at a time. A source within a graph may be a graph, so
/// evaluations may lie within one another: each takes the next piece.
class Scratch {
public:
    Scratch(std::size_t frames, std::size_t floats) : _piece(next())
    {
        Piece& piece = *_piece;
        if (piece.frameCount < frames) {
            piece.frames = hwy::AllocateAligned<FrameBlock>(frames);
            piece.frameCount = frames;
        }
        if (piece.floatCount < floats) {
            piece.floats = hwy::AllocateAligned<float>(floats);
            piece.floatCount = floats;
        }
    }
    ~Scratch() { --depth(); }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    [[nodiscard]] FrameBlock* frames() const { return _piece->frames.get(); }
    [[nodiscard]] float* floats() const { return _piece->floats.get(); }

private:
    struct Piece {
        hwy::AlignedFreeUniquePtr<FrameBlock[]> frames;
        hwy::AlignedFreeUniquePtr<float[]> floats;
        std::size_t frameCount = 0;
        std::size_t floatCount = 0;
    };
    static std::size_t& depth()
    {
        static thread_local std::size_t used = 0;
        return used;
    }
    static Piece* next()
    {
        static thread_local std::vector<std::unique_ptr<Piece>> pieces;
        const std::size_t index = depth()++;
        if (index == pieces.size())
            pieces.push_back(std::make_unique<Piece>());
        return pieces[index].get();
    }

    Piece* _piece;
};

} // namespace isofront::fields::graph
