#pragma once

#include "FrameData.h"
#include "MeshStore.h"
#include "isofront/render/HandOver.h"

#include <cstdint>
#include <span>
#include <vector>

namespace isofront::render {

/// Which cells may be seen, by their boxes against the view's sides, the nearest first: what lies
/// in front then hides what lies behind before it costs anything.
///
/// @param order     receives indices into `cells`; reused to save allocations
/// @param pictures  cells that are part of none of these are left out
/// Cost: O(n log n), about 40 ns a cell.
void visibleInto(
    std::span<const StoredCell> cells,
    const GridView& view,
    std::vector<std::uint32_t>& order,
    std::uint32_t pictures = shared::kInBoth);

/// What cells are part of in a frame: those of their pictures that it shows, less those in which
/// voxels have all of a cell's place; and shared::kLooksUp if they have a part of it. Takes cells
/// of which nothing is left out of the order.
///
/// @param handOver  null: voxels have nothing
/// @param pictures  receives as many as there are cells; of those in the order only
void picturesInto(
    std::span<const StoredCell> cells,
    const hierarchy::Domain& domain,
    const HandOver* handOver,
    std::uint32_t shown,
    std::vector<std::uint32_t>& order,
    std::vector<std::uint32_t>& pictures);

/// Moves those of the cells last, in their order, that aren't shown in all pixels. Returns how many
/// they are.
/// @param pictures  of the cells, as `picturesInto` leaves them
std::size_t moveFadingLast(
    std::span<const std::uint32_t> pictures,
    std::uint32_t shown,
    std::vector<std::uint32_t>& order);

/// The pictures that a frame shows, by the weight of the present one.
std::uint32_t picturesShown(float weight);
/// Whether a thing that is part of some of the pictures that a frame shows isn't part of all.
inline bool isInTransition(std::uint32_t pictures, std::uint32_t shown)
{
    return (pictures & shown) != shown;
}
/// Whether a thing that is part of some pictures isn't shown in all pixels: because it is part of
/// one only of those that a frame shows, or a part of its place is another's.
inline bool isFading(std::uint32_t pictures, std::uint32_t shown)
{
    return isInTransition(pictures, shown) || (pictures & shared::kLooksUp) != 0;
}

} // namespace isofront::render
