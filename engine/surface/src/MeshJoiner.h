#pragma once

#include "isofront/surface/MeshExtraction.h"

#include <isofront/core/FlatMap.h>
#include <isofront/core/Hash.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/CellId.h>
#include <isofront/hierarchy/Domain.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace isofront::surface {

/// A cell of the front on its way into the whole mesh. Reused from block to block: its columns keep
/// their memory.
struct JoinedCell {
    hierarchy::CellId id;
    extractor::CellMesh mesh;
    extractor::CellTrace trace;

    // What `MeshJoiner::number` finds out.
    std::vector<std::uint32_t> borderNumber; ///< in the whole mesh, of each border vertex
    std::uint32_t firstNew = 0;              ///< borders with a number from here on are its own
    std::uint32_t firstInterior = 0;         ///< number of the first vertex that is no border
    std::size_t firstIndex = 0;              ///< where its triangles stand in the whole mesh
};

/// Finds border vertices again by the lattice edge that they lie on.
///
/// A vertex in the interior of a face belongs to two cells at most, and is forgotten as soon as the
/// second one has asked for it, so that what is held grows with the front's open edges and not with
/// its area.
///
/// Thread: one at a time.
class BorderNumbers {
public:
    /// @param latticeSize  of the cells
    /// @param finestLevel  of the cells: their corners are multiples of a power of two, by which
    ///                     keys are made short where that is enough
    BorderNumbers(int latticeSize, int finestLevel);

    /// The number of a vertex: `next` if it has none yet, which must not be all ones.
    std::uint32_t numberOf(const extractor::BorderVertex& border, std::uint32_t next);
    /// Fetches from memory what `numberOf` will look at.
    void prepareFor(const extractor::BorderVertex& border) const;
    /// Memory held [bytes].
    [[nodiscard]] std::size_t bytes() const { return _short.bytes() + _long.bytes(); }

private:
    [[nodiscard]] std::uint64_t shortKey(const std::array<std::int64_t, 3>& key) const;

    using LongKey = std::array<std::int64_t, 3>;
    struct ShortHash {
        std::size_t operator()(std::uint64_t key) const { return core::mixed(key); }
    };
    struct LongHash {
        std::size_t operator()(const LongKey& key) const
        {
            std::uint64_t hash = 0;
            for (const std::int64_t word : key)
                hash = core::hashCombined(hash, static_cast<std::uint64_t>(word));
            return hash;
        }
    };

    unsigned _shift; ///< zero bits at the end of each coordinate of a key
    unsigned _bits;  ///< of each coordinate after the shift
    bool _isShort;
    core::FlatMap<std::uint64_t, std::uint32_t, ShortHash> _short{~std::uint64_t{0}};
    core::FlatMap<LongKey, std::uint32_t, LongHash> _long{LongKey{-1, -1, -1}};
};

/// Puts the meshes of cells together to one, cell after cell: border vertices that cells share
/// become one, all else is copied. The result depends on the order of the cells alone.
///
/// Each cell is first numbered, which is quick and has to be done in order, and then written, which
/// may be done for many cells at once.
///
/// Thread: `number` and `setSizes` one at a time; `write` any number at once, also beside them as
/// long as the mesh `fits`.
class MeshJoiner {
public:
    /// @param hasAttributes  whether cells with triangles have attributes
    MeshJoiner(
        const hierarchy::Domain& domain, int latticeSize, int finestLevel, bool hasAttributes);

    /// Gives the cell's vertices and triangles their places.
    /// @return false if there are more vertices than 32 bits can number
    bool number(JoinedCell& cell);
    /// Sets memory aside for what so many cells are likely to need, so that the mesh needn't move
    /// as it grows. What isn't used is never touched, and so not taken from the system.
    /// @param most  triangles, whatever the cells
    void reserve(TriangleMesh& mesh, std::size_t cells, std::size_t most) const;
    /// Makes the mesh as large as what has been numbered so far, and leaves unset what is new.
    void setSizes(TriangleMesh& mesh) const;
    /// Whether `setSizes` will leave the mesh where it is in memory.
    [[nodiscard]] bool fits(const TriangleMesh& mesh) const;
    /// Writes a numbered cell for which there is room.
    /// @param bounds  grows by the positions written
    void write(const JoinedCell& cell, TriangleMesh& mesh, core::Box& bounds) const;

    [[nodiscard]] std::size_t vertexCount() const { return _vertices; }
    [[nodiscard]] std::size_t indexCount() const { return _indices; }
    /// Memory held [bytes].
    [[nodiscard]] std::size_t bytes() const { return _borders.bytes(); }

private:
    hierarchy::Domain _domain;
    int _latticeSize;
    glm::dmat3 _normalMatrix;
    bool _mirrors;
    bool _hasAttributes;
    BorderNumbers _borders;
    std::uint32_t _vertices = 0;
    std::size_t _indices = 0;
};

} // namespace isofront::surface
