#include "ChunkOccupancy.h"

#include <bit>

namespace isofront::voxels {

ChunkOccupancy::ChunkOccupancy(std::span<const Voxel> voxels)
{
    // dense first, because voxels come row by row; 2 MiB that are gone again at the end
    std::vector<std::uint64_t> fine(std::size_t{1} << 18U);
    std::vector<std::uint64_t> middle(std::size_t{1} << 12U);
    std::array<std::uint64_t, 64> coarse{};
    std::uint64_t root = 0;
    for (const Voxel& voxel : voxels) {
        const std::uint32_t x = voxel.x();
        const std::uint32_t y = voxel.y();
        const std::uint32_t z = voxel.z();
        const std::uint32_t a = partOf(x, y, z, 6);
        const std::uint32_t b = partOf(x, y, z, 4);
        const std::uint32_t c = partOf(x, y, z, 2);
        const std::uint32_t d = partOf(x, y, z, 0);
        root |= std::uint64_t{1} << a;
        coarse[a] |= std::uint64_t{1} << b;
        middle[a << 6U | b] |= std::uint64_t{1} << c;
        fine[a << 12U | b << 6U | c] |= std::uint64_t{1} << d;
    }

    const auto forEach = [](std::uint64_t mask, const auto& part) {
        for (; mask != 0; mask &= mask - 1)
            part(static_cast<std::uint32_t>(std::countr_zero(mask)));
    };
    std::vector<Inner> second;
    std::vector<Inner> third;
    forEach(root, [&](std::uint32_t a) {
        second.push_back({coarse[a], static_cast<std::uint32_t>(third.size())});
        forEach(coarse[a], [&](std::uint32_t b) {
            const std::uint64_t mask = middle[a << 6U | b];
            third.push_back({mask, static_cast<std::uint32_t>(_leaves.size())});
            forEach(
                mask, [&](std::uint32_t c) { _leaves.push_back(fine[a << 12U | b << 6U | c]); });
        });
    });
    _inner.reserve(1 + second.size() + third.size());
    _inner.push_back({root, 1});
    const auto beforeThird = static_cast<std::uint32_t>(1 + second.size());
    for (const Inner& node : second)
        _inner.push_back({node.mask, beforeThird + node.first});
    _inner.insert(_inner.end(), third.begin(), third.end());
    _leaves.shrink_to_fit();
}

} // namespace isofront::voxels
