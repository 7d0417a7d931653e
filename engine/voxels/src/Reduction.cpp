#include "Reduction.h"

#include <isofront/voxels/Chunk.h>

namespace isofront::voxels {

namespace {

/// Where a child's voxel lies in the parent, with its faces.
std::uint32_t placeInParent(std::uint32_t place, std::uint32_t child)
{
    constexpr std::uint32_t kHalf = kChunkEdge / 2;
    const Voxel voxel{place, 0};
    return packPlace(
        voxel.x() / 2 + (child & 1U) * kHalf,
        voxel.y() / 2 + (child >> 1U & 1U) * kHalf,
        voxel.z() / 2 + (child >> 2U) * kHalf,
        voxel.faces());
}

/// Sorts by 24 bits above the lowest 32, keeping the order of equals.
void sortByPlace(std::vector<std::uint64_t>& keys, std::vector<std::uint64_t>& other)
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

void add(WeightedVoxel& sum, const WeightedVoxel& part)
{
    sum.place |= part.place; // of equal places: the faces are OR-ed
    for (std::size_t i = 0; i < sum.normal.size(); ++i)
        sum.normal[i] += part.normal[i];
    sum.area += part.area;
    for (std::size_t i = 0; i < sum.colour.size(); ++i)
        sum.colour[i] += part.colour[i];
}

bool hasNormal(const WeightedVoxel& voxel)
{
    return voxel.normal[0] != 0 || voxel.normal[1] != 0 || voxel.normal[2] != 0;
}

} // namespace

std::vector<WeightedVoxel>
reduced(const std::array<std::span<const WeightedVoxel>, 8>& children, ReductionScratch& scratch)
{
    scratch.gathered.clear();
    scratch.keys.clear();
    for (std::uint32_t child = 0; child < children.size(); ++child) {
        for (WeightedVoxel voxel : children[child]) {
            voxel.place = placeInParent(voxel.place, child);
            scratch.keys.push_back(
                static_cast<std::uint64_t>(voxel.order()) << 32U | scratch.gathered.size());
            scratch.gathered.push_back(voxel);
        }
    }
    sortByPlace(scratch.keys, scratch.sorted);

    std::vector<WeightedVoxel> parents;
    for (std::size_t i = 0; i < scratch.keys.size();) {
        const std::uint64_t place = scratch.keys[i] >> 32U;
        const WeightedVoxel& first = scratch.gathered[scratch.keys[i] & 0xffffffffU];
        WeightedVoxel sum = first;
        for (++i; i < scratch.keys.size() && scratch.keys[i] >> 32U == place; ++i)
            add(sum, scratch.gathered[scratch.keys[i] & 0xffffffffU]);
        if (!hasNormal(sum)) // two sides of a sheet: either is better than none
            sum.normal = first.normal;
        parents.push_back(sum);
    }
    return parents;
}

} // namespace isofront::voxels
