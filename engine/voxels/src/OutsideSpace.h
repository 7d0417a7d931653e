#pragma once

#include "EmptySpace.h"
#include "ScratchFile.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// A chunk of level 0 between the passes: what it left in the scratch file.
struct ScratchChunk {
    std::array<std::uint32_t, 3> place{}; ///< among the chunks
    std::uint64_t voxelsAt = 0;
    std::uint32_t voxels = 0;
    std::uint64_t coloursAt = 0; ///< of each voxel, where models have colours
    std::uint64_t facesAt = 0;
    std::uint32_t faces = 0; ///< voxels that have attributes of single faces
    std::uint32_t parts = 0; ///< of its empty space
    std::array<std::uint64_t, kFaces> layersAt{};
    std::array<std::uint32_t, kFaces> layerRuns{};
};

/// Which empty space is connected with what lies around all chunks.
///
/// Each chunk tells the parts of its own empty space and what its six border layers look like; here
/// parts that meet across borders become one.
class OutsideSpace {
public:
    /// @param counts  chunks along each axis
    OutsideSpace(const std::array<std::uint32_t, 3>& counts, const ScratchFile& scratch);

    /// Takes the chunks that have voxels; all others are empty.
    std::optional<core::Error> build(const std::vector<ScratchChunk>& chunks);

    /// Whether a part of a chunk's empty space is outside.
    [[nodiscard]] bool isOutside(const ScratchChunk& chunk, EmptyLabel part) const;
    /// Which cubes of the layer beyond a chunk's face are empty and outside, by bit, in the order
    /// of EmptySpace::layer.
    core::Result<std::vector<std::uint64_t>> beyond(const ScratchChunk& chunk, Face face) const;
    /// Parts that are closed off.
    [[nodiscard]] std::uint64_t closedParts() const { return _closed; }

private:
    static constexpr std::uint32_t kNone = 0xffffffffU;

    [[nodiscard]] std::size_t indexOf(const std::array<std::uint32_t, 3>& place) const
    {
        return place[0] + std::size_t{_counts[0]} * (place[1] + std::size_t{_counts[1]} * place[2]);
    }
    core::Result<std::vector<EmptySpace::LayerRun>> layer(std::size_t index, Face face) const;
    std::uint32_t root(std::uint32_t part);
    void connect(std::uint32_t a, std::uint32_t b);
    void connect(
        const std::vector<EmptySpace::LayerRun>& a,
        std::uint32_t firstA,
        const std::vector<EmptySpace::LayerRun>& b,
        std::uint32_t firstB);

    std::array<std::uint32_t, 3> _counts;
    const ScratchFile& _scratch;
    const std::vector<ScratchChunk>* _chunks = nullptr;
    std::vector<std::uint32_t> _chunkAt; ///< by index: its place in the list, or kNone
    std::vector<std::uint32_t> _first;   ///< by index: the first of its parts; part 0 is outside
    std::vector<std::uint32_t> _parent;
    std::uint64_t _closed = 0;
};

} // namespace isofront::voxels
