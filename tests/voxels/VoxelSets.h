#pragma once

#include "Models.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdlib>
#include <deque>
#include <map>
#include <vector>

namespace isofront::tests {

/// A voxel's place in the whole model.
using Cube = std::array<int, 3>;

/// The voxels of a level by their place in the whole model.
inline std::map<Cube, voxels::Voxel> voxelsOf(const KeptChunks& kept, std::uint32_t level)
{
    std::map<Cube, voxels::Voxel> found;
    for (const auto& [key, chunk] : kept.chunks)
        if (key.level == level)
            for (const voxels::Voxel& v : chunk.voxels)
                found[{
                    static_cast<int>(key.x * voxels::kChunkEdge + v.x()),
                    static_cast<int>(key.y * voxels::kChunkEdge + v.y()),
                    static_cast<int>(key.z * voxels::kChunkEdge + v.z())}] = v;
    return found;
}

/// All of a cube of space, and which of it can be reached from its border through what is empty.
class Flood {
public:
    Flood(const std::map<Cube, voxels::Voxel>& full, int edge, bool diagonally)
        : _edge(static_cast<std::size_t>(edge) + 2), _state(_edge * _edge * _edge)
    {
        for (const auto& [cube, voxel] : full)
            at(cube) = kFull;
        std::deque<Cube> front{{-1, -1, -1}};
        at(front.front()) = kReached;
        while (!front.empty()) {
            const Cube here = front.front();
            front.pop_front();
            for (int z = -1; z <= 1; ++z)
                for (int y = -1; y <= 1; ++y)
                    for (int x = -1; x <= 1; ++x) {
                        if (!diagonally && std::abs(x) + std::abs(y) + std::abs(z) != 1)
                            continue;
                        const Cube next{here[0] + x, here[1] + y, here[2] + z};
                        if (std::ranges::any_of(next, [&](int c) { return c < -1 || c > edge; }))
                            continue;
                        if (at(next) == kEmpty) {
                            at(next) = kReached;
                            front.push_back(next);
                        }
                    }
        }
    }
    [[nodiscard]] bool reaches(const Cube& cube) { return at(cube) == kReached; }

private:
    static constexpr char kEmpty = 0;
    static constexpr char kFull = 1;
    static constexpr char kReached = 2;
    char& at(const Cube& c)
    {
        const auto place = [](int i) { return static_cast<std::size_t>(i + 1); };
        return _state[place(c[0]) + _edge * (place(c[1]) + _edge * place(c[2]))];
    }
    std::size_t _edge;
    std::vector<char> _state;
};

} // namespace isofront::tests
