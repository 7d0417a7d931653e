#include <isofront/voxels/Chunk.h>

namespace isofront::voxels {

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
