#pragma once

#include "FieldGrid.h"
#include "LatticeTriangle.h"
#include "VoxelGrid.h"

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::voxels {

/// Turns a field into the voxels of a part of a chunk. Thread: one at a time.
///
/// Parts are cut in halves as long as the field's bounds don't prove them empty, down to blocks
/// that are sampled whole. Between two middles on different sides of the surface, the field halfway
/// tells which of the two cubes it passes through.
class FieldRasteriser {
public:
    FieldRasteriser();

    struct Settings {
        Separability separability = Separability::six;
        bool closed = false;
    };
    struct Counts {
        std::uint64_t samples = 0;
        std::uint64_t sanitised = 0;
    };
    /// Adds the voxels of a brick, in any order, to a list; faces name their voxel by its order.
    /// @param chunk  the chunk's first voxel
    /// @param brick  the voxels wanted, in the chunk
    void
    run(const FieldGrid& grid,
        const std::array<std::int64_t, 3>& chunk,
        const VoxelRange& brick,
        const Settings& settings,
        VoxelList& list,
        Counts& counts);

private:
    /// What is known of a middle.
    enum State : std::uint8_t { outside, inside, noData };
    /// Where the surface passes between two middles.
    struct Crossing {
        std::array<std::int64_t, 3> voxel{}; ///< of the lower middle
        std::uint32_t axis = 0;
        bool insideBelow = false;
        double below = 0; ///< value of the lower middle less the isovalue
        double above = 0; ///< of the upper one
    };
    /// A surface that passes through a voxel.
    struct Hit {
        std::array<std::int64_t, 3> voxel{};
        Face outward = Face::lowX; ///< the axis of the crossing
    };
    struct Shown {
        std::uint32_t order = 0;
        Face face = Face::lowX;
        WeightedFace attributes;
    };

    void split(const VoxelRange& lower);
    void block(const VoxelRange& lower, bool allInside);
    void findCrossings(const VoxelRange& lower);
    void addCrossings();
    void addWall(const std::array<std::int64_t, 3>& voxel, std::size_t axis, bool up);
    void addTouched(const VoxelRange& lower);
    void add(const Hit& hit, const glm::dvec3& normal, std::uint32_t word);
    void finish(VoxelList& list);
    void count(const std::vector<float>& values);
    [[nodiscard]] bool isOwn(const std::array<std::int64_t, 3>& voxel) const;
    [[nodiscard]] std::array<std::uint32_t, 3>
    inChunk(const std::array<std::int64_t, 3>& voxel) const;
    /// Which of the grid's.
    std::uint32_t at(const std::array<std::int64_t, 3>& voxel);
    void add(std::uint32_t voxel, const WeightedFace& part);

    std::array<float, 256> _linear;
    const FieldGrid* _field = nullptr;
    Settings _settings;
    Counts* _counts = nullptr;
    std::array<std::int64_t, 3> _chunk{};
    VoxelRange _brick; ///< on the whole lattice

    VoxelGrid _grid; ///< those that the surface passes through are marked
    FieldPoints _points;
    std::vector<float> _values;
    std::vector<float> _corners;
    std::vector<State> _states;
    std::vector<Crossing> _crossings;
    std::vector<Hit> _hits;
    std::vector<glm::dvec3> _normals;
    std::vector<std::uint32_t> _words;
    std::vector<Shown> _shown;
};

} // namespace isofront::voxels
