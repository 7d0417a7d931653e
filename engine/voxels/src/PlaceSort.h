#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// Sorts by 24 bits above the lowest 32, keeping the order of equals: by a voxel's place, if the
/// lowest say which voxel it is.
/// @param other  scratch
inline void sortByPlace(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& other)
{
    other.resize(keys.size());
    for (unsigned shift = 32; shift < 56; shift += 8) {
        std::array<std::size_t, 257> begin{};
        for (const std::uint64_t key : keys)
            ++begin[(key >> shift & 0xffU) + 1];
        for (std::size_t i = 1; i < begin.size(); ++i)
            begin[i] += begin[i - 1];
        for (const std::uint64_t key : keys)
            other[begin[key >> shift & 0xffU]++] = key;
        keys.swap(other);
    }
}

} // namespace isofront::voxels
