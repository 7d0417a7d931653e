#pragma once

#include "FrameData.h"
#include "MeshStore.h"

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

/// Moves those of the cells last, in their order, that are part of one only of the pictures that a
/// frame shows. Returns how many they are.
std::size_t moveFadingLast(
    std::span<const StoredCell> cells, std::uint32_t shown, std::vector<std::uint32_t>& order);

/// The pictures that a frame shows, by the weight of the present one.
std::uint32_t picturesShown(float weight);
/// Whether a thing that is part of some pictures is part of one only of those that a frame shows.
inline bool isFading(std::uint32_t pictures, std::uint32_t shown)
{
    return (pictures & shown) != shown;
}

} // namespace isofront::render
