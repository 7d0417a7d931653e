#pragma once

#include "CellGeometry.h"
#include "CrossingKernel.h"
#include "RoughMesh.h"
#include "Samples.h"
#include "isofront/extractor/CellExtractor.h"

#include <isofront/hierarchy/Tetrahedron.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// What a worker reuses from cell to cell while it contours.
struct ContourScratch {
    std::vector<std::uint8_t> inside;         ///< of a block, and some zeros
    std::vector<std::uint8_t> configurations; ///< of a block, by the hexahedra's places
    std::vector<std::uint16_t> cut;           ///< the hexahedra of a block that the surface cuts
    std::vector<std::uint16_t> vertexOfEdge;  ///< kNoVertex for all between cells
    std::vector<std::uint16_t> vertexOfPoint; ///< the same
    /// The lattice edges and points that the vertices lie on: points count from kFirstPoint.
    std::vector<std::uint32_t> origins;
    std::uint32_t originCount = 0;
    CrossingBlock crossings;

    static constexpr std::uint32_t kFirstPoint = 1U << 16U;
};

/// Makes the triangles of one cell from its samples.
class Contour {
public:
    /// @param mesh  is emptied, and receives the vertices and triangles
    Contour(
        const CellGeometry& geometry,
        const VolumeMesh& volumeMesh,
        const ExtractionSettings& settings,
        const Samples& samples,
        ContourScratch& scratch,
        RoughMesh& mesh);

    /// The surface in all hexahedra, and its caps on those faces of the cell that lie on the
    /// domain's walls if it is to be closed there. Vertices stand in the order of their first use.
    void run(const hierarchy::Tetrahedron& cell, bool closeWalls);

private:
    static constexpr std::size_t kMostCorners = 15; ///< of the triangles of a hexahedron
    struct Cut;
    class Cuts;

    void march();
    const std::uint8_t* configurationsOf(std::size_t block);
    void capWalls(const hierarchy::Tetrahedron& cell);
    void capQuad(const BoundaryQuad& quad);
    std::uint16_t crossingOf(std::uint16_t edge);
    std::uint16_t wallPoint(std::uint16_t point);
    void placeVertices();
    void placeAtBorderOfData(std::size_t first, std::size_t count);
    void dropCaps();

    const CellGeometry& _geometry;
    const VolumeMesh& _volumeMesh;
    const ExtractionSettings& _settings;
    const Samples& _samples;
    ContourScratch& _scratch;
    RoughMesh& _mesh;
    bool _leavesData; ///< some sample is outside of the field's data
};

} // namespace isofront::extractor
