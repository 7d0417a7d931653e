#pragma once

#include <isofront/voxels/VoxelRay.h>
#include <isofront/voxels/Voxelization.h>

#include <array>
#include <cstdint>
#include <optional>

namespace isofront::voxels {

/// A ray in integers, and the exact walk of it from cube to cube.
///
/// The cube of all levels has 2^30 steps along each edge, and so does the longest component of the
/// direction. Start and direction are rounded to whole steps once; after that nothing is rounded.
///
/// Ties: the ray is walked as if its start lay infinitely little further, by e along x, e^2 along
/// y and e^3 along z. So a start on a face belongs to the cube above it, and where the ray meets an
/// edge or corner, it crosses the planes one after the other: those that it crosses upward first,
/// in the order x, y, z, then those downward, in the order z, y, x. It goes from cube to cube
/// across faces only, and enters the same cubes at every level of detail.
class LatticeRay {
public:
    static constexpr int kBits = 30; ///< of the edge of the cube [steps]

    static constexpr std::size_t kNoAxis = 3;
    /// Where the walk is: in a cube of level 0, entered across a plane.
    struct Place {
        std::array<std::int32_t, 3> cell{}; ///< of level 0
        std::size_t axis = kNoAxis;         ///< of the plane; none at the start
        std::int64_t rise = 0;              ///< from the start to the plane, along the axis [steps]
    };

    /// @return nothing if the ray comes nowhere near the cube, or isn't finite
    static std::optional<LatticeRay> from(const VoxelLattice& lattice, const Ray& ray);
    /// As given, for tests.
    /// @param start      from -2^30 to 2^31 [steps]
    /// @param direction  from -2^30 to 2^30, not all zero [steps]
    /// @param cellBits   of the edge of the cube [cells of level 0]
    LatticeRay(
        const std::array<std::int64_t, 3>& start,
        const std::array<std::int64_t, 3>& direction,
        int cellBits);

    /// Where the walk begins: at the start, or where the ray enters the cube; nothing if it
    /// doesn't.
    [[nodiscard]] std::optional<Place> begin() const;

    /// Goes on to the first place beyond the cube of 2^bits cells, aligned to its size, that the
    /// walk is in.
    void leave(Place& place, int bits) const;

    /// Whether a place lies in the cube of all levels.
    [[nodiscard]] bool contains(const Place& place) const
    {
        const std::int32_t outside = place.cell[0] | place.cell[1] | place.cell[2];
        return outside >> _cellBits == 0; // a negative one has its highest bits set
    }
    /// How far a place's plane is from the ray's own start [world]. Of two places on one ray, the
    /// later is never nearer.
    [[nodiscard]] double distance(const Place& place) const;
    /// The face of a cube by which the walk came in; nothing at the start.
    [[nodiscard]] std::optional<Face> face(const Place& place) const;

private:
    /// What the walk does along an axis.
    struct Axis {
        std::int64_t start = 0;
        std::int64_t direction = 0;
        std::int64_t size = 0; ///< of the direction
        double inverse = 0;    ///< of the size
        std::size_t rank = 0;  ///< at ties: the lower crosses its plane first
    };
    /// Whether a plane of axis a is crossed before one of axis b.
    [[nodiscard]] bool
    before(std::size_t a, std::int64_t riseA, std::size_t b, std::int64_t riseB) const
    {
        const Axis& first = _axis[a];
        const Axis& second = _axis[b];
        const std::int64_t left = riseA * second.size; // both below 2^62
        const std::int64_t right = riseB * first.size;
        return left < right || (left == right && first.rank < second.rank);
    }
    /// The cell along an axis at the moment when a plane of another is crossed.
    [[nodiscard]] std::int64_t
    cellAt(const Axis& axis, const Axis& crossed, std::int64_t rise) const;

    std::array<Axis, 3> _axis{};
    int _cellBits = 0;
    int _stepBits = 0;   ///< of a cell
    double _scale = 1;   ///< from the parameter along the direction to world distance
    double _skipped = 0; ///< distance from the ray's own start to this one's [world]
};

} // namespace isofront::voxels
