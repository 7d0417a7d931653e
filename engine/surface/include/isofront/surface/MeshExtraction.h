#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/DetailSettings.h>
#include <isofront/surface/TriangleMesh.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <stop_token>

namespace isofront::surface {

/// How fine a mesh to extract. One of three ways.
struct Detail {
    enum class Kind {
        level, ///< one level wherever there is a surface
        error, ///< finer until the estimated distance error is small enough everywhere
        view,  ///< as a viewer needs it
    };
    Kind kind = Kind::level;
    int level = 0;         ///< for `level`; the finest that may be used for the others
    double maxError = 0;   ///< for `error` [world]
    hierarchy::View view;  ///< for `view`
    double pixelError = 2; ///< for `view` [px]
    /// For `view`: what decides beside the pixels.
    DetailSettings settings;
};

struct MeshExtractionOptions {
    Detail detail;
    /// What the work may hold at once, about; over it the answer is ErrorCode::resourceLimit, as
    /// early as it can be told [bytes].
    std::size_t memoryLimit = std::size_t{8} << 30U;
    /// The most triangles of the mesh; 0 for any number. Where what is asked for has more, it is
    /// made coarser: by single levels, or by as large errors as leave no more, in steps of an
    /// eighth of a doubling.
    std::size_t maxTriangles = 0;
    /// Called now and then from the calling thread: what is being done, and a share in [0, 1], or
    /// less than 0 where none can be told.
    std::function<void(const char*, double)> progress;
    std::stop_token stop;
};

/// A whole mesh, joined at the borders of cells, and what it took.
struct ExtractedMesh {
    TriangleMesh mesh;
    std::uint64_t cells = 0;        ///< of the front
    std::uint64_t cellsSkipped = 0; ///< of them proved empty, never sampled
    std::uint64_t samples = 0;
    std::uint64_t sanitisedSamples = 0;
    int finestLevel = 0;
    /// Level and errors that it was extracted by: as asked for, or coarser for `maxTriangles`.
    Detail detail;
    double coarser = 1;       ///< steps or errors over those that were asked for
    double errorRms = 0;      ///< estimated, over all cells by triangles [world]; if asked for
    double errorMax = 0;      ///< the same, largest [world]
    double frontSeconds = 0;  ///< finding the cells
    double sampleSeconds = 0; ///< these six summed over threads
    double contourSeconds = 0;
    double smoothSeconds = 0;
    double simplifySeconds = 0;
    double normalSeconds = 0;
    double joinSeconds = 0;
};

/// Extracts the surface of a field as one mesh, by the same cells as the live surface.
///
/// The mesh doesn't depend on the number of threads, to the last byte.
/// Errors: resourceLimit (over the memory limit, which is foretold by the growth of the front
/// before much is done where it is far over; more than 2^32 vertices; more than `maxTriangles` even
/// at its coarsest), interrupted.
core::Result<ExtractedMesh> extractMesh(
    std::shared_ptr<const extractor::CellExtractor> extractor,
    core::Jobs& jobs,
    const MeshExtractionOptions& options);

} // namespace isofront::surface
