#pragma once

#include <isofront/voxels/Chunk.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::voxels {

/// Which cubes of a chunk are full: a tree of 64-bit masks, each for 4 x 4 x 4 parts. Answers how
/// much empty space there is around a cube, in at most four steps. About a byte a voxel.
///
/// Thread: any number may read.
class ChunkOccupancy {
public:
    explicit ChunkOccupancy(std::span<const Voxel> voxels);

    static constexpr int kFullCube = -1;
    /// The edge of an empty cube around a place, aligned to its size, as a power of two: 0 to 8;
    /// kFullCube for a voxel.
    [[nodiscard]] int emptyAround(std::uint32_t x, std::uint32_t y, std::uint32_t z) const
    {
        std::uint32_t node = 0;
        int bits = 6; // of a part's edge
        for (;; bits -= 2) {
            const std::uint32_t part = partOf(x, y, z, bits);
            const std::uint64_t mask = bits > 0 ? _inner[node].mask : _leaves[node];
            if ((mask >> part & 1U) == 0) {
                if (mask == 0)
                    return bits + 2;
                return (mask >> (part & 0x38U) & 0xffU) == 0 ? bits + 1 : bits;
            }
            if (bits == 0)
                return kFullCube;
            const std::uint64_t lower = mask & ((std::uint64_t{1} << part) - 1);
            node = _inner[node].first + static_cast<std::uint32_t>(__builtin_popcountll(lower));
        }
    }

    /// Memory that it takes.
    [[nodiscard]] std::size_t bytes() const
    {
        return _inner.capacity() * sizeof(Inner) + _leaves.capacity() * sizeof(std::uint64_t);
    }

private:
    struct Inner {
        std::uint64_t mask = 0;
        std::uint32_t first = 0; ///< of its parts: an inner node, or a leaf in the last row of them
    };

    /// Which of 4 x 4 x 4 parts with edge 2^bits a place is in, eighths of the whole together.
    static std::uint32_t partOf(std::uint32_t x, std::uint32_t y, std::uint32_t z, int bits)
    {
        constexpr std::array<std::uint32_t, 4> kSpread{0, 1, 8, 9};
        return kSpread[x >> bits & 3U] | kSpread[y >> bits & 3U] << 1U |
               kSpread[z >> bits & 3U] << 2U;
    }

    std::vector<Inner> _inner; ///< of parts with edge 64, then 16, then 4
    std::vector<std::uint64_t> _leaves;
};

} // namespace isofront::voxels
