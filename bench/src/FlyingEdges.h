#pragma once

#include "isofront/bench/Timing.h"

#include <isofront/volume/LoadVolume.h>

#include <glm/ext/vector_int3_sized.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::bench {

/// What VTK's flying edges made of a volume, normals included.
struct FlyingEdgesResult {
    Timing timing;
    std::size_t triangles = 0;
};

/// VTK's flying edges on the voxels of a dense volume, in the file's own type where that is uint8
/// or int16, and float otherwise.
class FlyingEdges {
public:
    explicit FlyingEdges(const volume::LoadedVolume& volume);

    /// Runs it once. Nothing if the peer was not built, which takes VTK.
    [[nodiscard]] std::optional<FlyingEdgesResult> run(double isovalue, std::size_t threads) const;

private:
    glm::ivec3 _size;
    std::size_t _bytesEach; ///< of a voxel
    std::vector<std::uint8_t> _voxels;
};

} // namespace isofront::bench
