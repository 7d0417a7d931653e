#pragma once

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::volume {

/// Which blocks of 8^3 voxels a mesh touches, to tell how many a level set of it will have before
/// it is made.
class MeshBlocks {
public:
    static constexpr int kEdge = 8; ///< of a block [voxels]

    /// @param size   of the mesh's box, whose low corner is the origin [voxels]
    /// @param reach  from the mesh that the level set has [voxels]
    MeshBlocks(const glm::dvec3& size, double reach);

    /// Corners within the box.
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c);

    /// Blocks within reach of what was added; never too few, and too many by about one layer.
    [[nodiscard]] std::uint64_t countWithinReach() const;

private:
    [[nodiscard]] std::size_t indexOf(const glm::ivec3& block) const;

    glm::ivec3 _margin; ///< blocks around the box
    glm::ivec3 _size;   ///< blocks along each axis
    std::vector<bool> _touched;
};

} // namespace isofront::volume
