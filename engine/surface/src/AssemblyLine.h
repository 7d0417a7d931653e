#pragma once

#include "MeshJoiner.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>

#include <cstddef>
#include <functional>
#include <optional>

namespace isofront::surface {

/// What is done with each cell on its way into the whole mesh.
struct AssemblySteps {
    /// Makes the cell of that number. Any thread.
    std::function<void(std::size_t, JoinedCell&)> extract;
    /// Sums what a cell tells. In the order of the cells, one at a time.
    std::function<void(JoinedCell&)> count;
    /// Called every so many cells, one at a time, with how many are done and the memory that the
    /// mesh and its making take [bytes]. An error ends the work.
    std::function<std::optional<core::Error>(std::size_t, std::size_t)> check;
    /// The same from the calling thread alone.
    std::function<void(std::size_t)> progress;
};

/// What it has brought.
struct Assembled {
    std::optional<core::Error> error; ///< that ended the work: the mesh is then undefined
    double seconds = 0;               ///< of numbering and writing, summed over threads
};

/// Extracts cells and joins them to one mesh. A few cells at a time go all the way in one thread,
/// so that they are still in its cache when they are written; only numbering waits until all cells
/// before them have been numbered. The mesh depends on the order of the cells alone.
///
/// Throws what a step throws, std::bad_alloc above all, once all threads have ended.
///
/// @param latticeSize  of the cells
/// @param mesh         is empty, and may have memory set aside
Assembled assemble(
    std::size_t cells,
    int latticeSize,
    core::Jobs& jobs,
    const AssemblySteps& steps,
    MeshJoiner& joiner,
    TriangleMesh& mesh);

} // namespace isofront::surface
