#include "Reduction.h"

#include "PlaceSort.h"

#include <isofront/voxels/Chunk.h>

#include <span>

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

bool hasNormal(const WeightedVoxel& voxel)
{
    return voxel.normal[0] != 0 || voxel.normal[1] != 0 || voxel.normal[2] != 0;
}

/// What each face of a voxel shows: of the children that show it those that are turned to it, as
/// far as they are; if none is, all alike.
WeightedFaces facesOf(std::span<const std::uint64_t> children, const ReductionScratch& scratch)
{
    WeightedFaces turned;
    WeightedFaces all;
    for (const std::uint64_t key : children) {
        const std::size_t index = key & 0xffffffffU;
        const WeightedVoxel& child = scratch.gathered[index];
        const WeightedFaces* own = scratch.faces[index];
        for (std::size_t face = 0; face < kFaces; ++face) {
            if ((child.place >> 24U & faceBit(static_cast<Face>(face))) == 0)
                continue;
            if (own != nullptr && own->faces[face].area > 0) {
                addAttributes(turned.faces[face], own->faces[face]);
                continue;
            }
            const WeightedFace seen{child.normal, child.area, child.colour};
            addAttributes(all.faces[face], seen);
            const float along = seen.normal[face / 2] * (face % 2 != 0 ? 1.0F : -1.0F);
            if (along > 0 && seen.area > 0)
                addAttributes(turned.faces[face], scaled(seen, along / seen.area));
        }
    }
    for (std::size_t face = 0; face < kFaces; ++face)
        if (turned.faces[face].area <= 0)
            turned.faces[face] = all.faces[face];
    return turned;
}

} // namespace

VoxelList reduced(const std::array<const VoxelList*, 8>& children, ReductionScratch& scratch)
{
    scratch.gathered.clear();
    scratch.faces.clear();
    scratch.keys.clear();
    for (std::uint32_t which = 0; which < children.size(); ++which) {
        if (children[which] == nullptr)
            continue;
        const VoxelList& child = *children[which];
        const std::size_t first = scratch.gathered.size();
        for (WeightedVoxel voxel : child.voxels) {
            voxel.place = placeInParent(voxel.place, which);
            scratch.keys.push_back(
                static_cast<std::uint64_t>(voxel.order()) << 32U | scratch.gathered.size());
            scratch.gathered.push_back(voxel);
        }
        scratch.faces.resize(scratch.gathered.size(), nullptr);
        for (const WeightedFaces& faces : child.faces)
            scratch.faces[first + faces.voxel] = &faces;
    }
    sortByPlace(scratch.keys, scratch.sorted);

    VoxelList parents;
    for (std::size_t i = 0; i < scratch.keys.size();) {
        const std::size_t begin = i;
        const std::uint64_t place = scratch.keys[i] >> 32U;
        const WeightedVoxel& first = scratch.gathered[scratch.keys[i] & 0xffffffffU];
        WeightedVoxel sum = first;
        for (++i; i < scratch.keys.size() && scratch.keys[i] >> 32U == place; ++i) {
            const WeightedVoxel& part = scratch.gathered[scratch.keys[i] & 0xffffffffU];
            sum.place |= part.place; // of equal places: the faces are OR-ed
            addAttributes(sum, part);
        }
        if (isMixed(sum)) {
            WeightedFaces faces =
                facesOf({scratch.keys.data() + begin, scratch.keys.data() + i}, scratch);
            faces.voxel = static_cast<std::uint32_t>(parents.voxels.size());
            parents.faces.push_back(faces);
        }
        if (!hasNormal(sum)) // two sides of a sheet: either is better than none
            sum.normal = first.normal;
        parents.voxels.push_back(sum);
    }
    return parents;
}

} // namespace isofront::voxels
