#pragma once

#include "CellGeometry.h"
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
    std::vector<std::uint16_t> vertexOfEdge;
    std::vector<std::uint16_t> vertexOfPoint;
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
    void march();
    void capWalls(const hierarchy::Tetrahedron& cell);
    void capQuad(const BoundaryQuad& quad);
    std::uint16_t crossingOf(std::uint16_t edge);
    std::uint16_t makeCrossing(std::uint16_t edge);
    std::uint16_t wallPoint(std::uint16_t point);
    [[nodiscard]] std::uint16_t nextVertex() const;
    void emit(std::uint16_t a, std::uint16_t b, std::uint16_t c);
    [[nodiscard]] glm::dvec3 samplePoint(std::uint16_t v) const;

    const CellGeometry& _geometry;
    const VolumeMesh& _volumeMesh;
    const ExtractionSettings& _settings;
    const Samples& _samples;
    ContourScratch& _scratch;
    RoughMesh& _mesh;
    bool _leavesData; ///< some sample is outside of the field's data
};

} // namespace isofront::extractor
