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
/// @param order  receives indices into `cells`; reused to save allocations
/// Cost: O(n log n), about 40 ns a cell.
void visibleInto(
    std::span<const StoredCell> cells, const GridView& view, std::vector<std::uint32_t>& order);

} // namespace isofront::render
