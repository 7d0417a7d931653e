#include <isofront/voxels/Chunk.h>

#include <algorithm>

namespace isofront::voxels {

FaceAttributes attributesOf(const Chunk& chunk, std::size_t voxel, Face face)
{
    const auto set = std::ranges::lower_bound(chunk.faceSets, voxel, {}, &FaceSet::voxel);
    if (set != chunk.faceSets.end() && set->voxel == voxel && (set->mask() & faceBit(face)) != 0)
        return chunk.faceAttributes[set->entry(face)];
    return {chunk.voxels[voxel].normal, chunk.colours.empty() ? 0 : chunk.colours[voxel]};
}

std::vector<std::uint32_t> facesOfEach(const Chunk& chunk)
{
    if (chunk.faceSets.empty())
        return {};
    std::vector<std::uint32_t> faces(chunk.voxels.size());
    for (const FaceSet& set : chunk.faceSets)
        faces[set.voxel] = set.faces;
    return faces;
}

std::vector<std::uint8_t> cappedFaces(const Chunk& chunk)
{
    constexpr std::uint32_t kLast = kChunkEdge - 1;
    std::vector<std::uint8_t> faces(chunk.voxels.size());
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const Voxel& voxel = chunk.voxels[i];
        unsigned mask = voxel.faces();
        const std::uint32_t place[3] = {voxel.x(), voxel.y(), voxel.z()};
        for (unsigned axis = 0; axis < 3; ++axis) {
            mask |= (place[axis] == 0 ? 1U : 0U) << 2 * axis;
            mask |= (place[axis] == kLast ? 2U : 0U) << 2 * axis;
        }
        faces[i] = static_cast<std::uint8_t>(mask);
    }
    return faces;
}

} // namespace isofront::voxels
