#include "StandIn.h"

#include <array>
#include <cstddef>

namespace isofront::voxels {

Chunk standInFor(const ChunkKey& key, const Chunk& above)
{
    const std::uint32_t levels = above.key.level - key.level;
    const std::uint32_t edge = kChunkEdge >> levels;
    const std::uint32_t within = (1U << levels) - 1;
    const std::array<std::uint32_t, 3> low{
        (key.x & within) * edge, (key.y & within) * edge, (key.z & within) * edge};
    Chunk part;
    part.key = above.key;
    for (std::size_t i = 0; i < above.voxels.size(); ++i) {
        Voxel voxel = above.voxels[i];
        const std::array<std::uint32_t, 3> place{voxel.x(), voxel.y(), voxel.z()};
        bool isWithin = true;
        std::uint32_t faces = voxel.faces();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            isWithin = isWithin && place[axis] >= low[axis] && place[axis] - low[axis] < edge;
            faces |= (place[axis] == low[axis] ? 1U : 0U) << (2 * axis);
            faces |= (place[axis] == low[axis] + edge - 1 ? 2U : 0U) << (2 * axis);
        }
        if (!isWithin)
            continue;
        voxel.place = packPlace(place[0], place[1], place[2], static_cast<std::uint8_t>(faces));
        part.voxels.push_back(voxel);
        if (!above.colours.empty())
            part.colours.push_back(above.colours[i]);
    }
    return part;
}

} // namespace isofront::voxels
