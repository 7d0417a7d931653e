#pragma once

#include <isofront/extractor/CellMesh.h>
#include <isofront/extractor/VolumeMesh.h>
#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/Tetrahedron.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace isofront::extractor {

struct CellFrame;
struct CellGeometry;
struct CellScratch;

/// Where normals come from. All of them see the field at the vertex's own filter radius.
enum class NormalSource {
    analytic,    ///< the field's own gradient; six samples for fields that have none
    sixSamples,  ///< central differences along the axes: an error of second order in the step
    fourSamples, ///< corners of a tetrahedron: two thirds of the cost, an error of first order
};

/// Where vertices lie.
enum class VertexPlacement {
    /// On the surface, as well as it can be told. Where it is curved, triangles then lie all on its
    /// inner side.
    onSurface,
    /// As far above it as makes the mean squared distance of the triangles least. Costs five or six
    /// gradients a vertex.
    balanced,
};

/// How cells are made into triangles. One set of values for all cells that are to fit together.
struct ExtractionSettings {
    /// n: lattice segments along an edge of a hexahedron; 4, 8 or 16 (1 and 2 are for tests). Time
    /// and samples grow with n^3, triangles with n^2, and the error falls with n^2.
    int latticeSize = 16;
    double isovalue = 0; ///< [field units]; solid is where the field is at or above it
    /// Scales the low-pass filter's radius: 0 samples the field as it is, 1 removes what the
    /// lattice can't hold, more is smoother still. Trades detail for fewer artefacts. At one half,
    /// caves, arches and thin bone stay that vanish at 1, for a third of the false detail gone.
    double filterStrength = 0.5;
    /// Filter radius at the corners of cells, where no radius follows from the cell itself: that of
    /// the finest cells that can occur [field].
    double cornerRadius = 0;
    /// Close the surface at the borders of the data and of the domain. Otherwise it ends there.
    bool closed = false;
    /// Don't sample cells that the field's bounds prove empty. The meshes are the same either way.
    bool skipEmptyCells = true;
    /// Passes that even out the triangles inside cells; 0 leaves them as they were contoured. Few
    /// slivers are left after one or two, and many passes round detail off. Vertices on borders of
    /// cells stay, and so do the slivers there.
    int smoothIterations = 0;
    /// After smoothing, bring vertices back to the surface by one Newton step. Costs a value and a
    /// gradient a vertex.
    bool reproject = false;
    /// Removes vertices inside cells as long as the root of the mean squared distance between what
    /// is removed and what stays is below this share of the axis step; 0 removes none. Errors reach
    /// about twice as much. Vertices on borders of cells stay.
    double simplifyError = 0;
    /// d: candidates that each removal is chosen from. More make a little fewer triangles, and take
    /// longer.
    int simplifyChoices = 8;
    VertexPlacement vertices = VertexPlacement::onSurface;
    /// Lets edges inside cells run along the directions in which the surface bends least, which
    /// lowers the error by a sixth to two fifths at the same number of triangles where the surface
    /// is smooth. Costs two or three times as long as contouring.
    bool alignEdges = false;
    NormalSource normals = NormalSource::analytic;
    /// Ask the field for its words at the vertices, if it has any: CellMesh::attributes.
    bool attributes = false;
    /// Fill in CellStats::errorRms and errorMax, at a cost of about a tenth.
    bool estimateError = false;

    bool operator==(const ExtractionSettings&) const = default;
};

/// A vertex on a face of the tetrahedron, and the lattice edge that it lies on: the neighbour
/// across the face has the same vertex under the same key.
struct BorderVertex {
    std::uint16_t vertex = 0;
    FeatureMask feature = 0; ///< of the lattice edge: a face, or an edge that more cells share
    /// Sum of the edge's two sample points, exact [sample units].
    std::array<std::int64_t, 3> key{};
};

/// What an extraction can tell beside its mesh.
struct CellTrace {
    std::vector<BorderVertex> borders;
    double sampleSeconds = 0;
    double contourSeconds = 0;
    double smoothSeconds = 0;
    double simplifySeconds = 0;
    double normalSeconds = 0;
};

/// What bounds say about a box, whatever the isovalue.
struct BoxBounds {
    core::Interval values;  ///< of the field
    bool isOutside = false; ///< of the data: nothing can be there
    bool holdsCaps = false; ///< a border at which the surface ends or is closed passes through
};

/// Extracts the surface in single cells, each on its own, so that the cells of any conforming front
/// fit together to the last bit.
///
/// Everything on a shared face - sample points, filter radii, values, vertices, normals - is
/// computed in double from exact integers in an order that both cells share, and vertices are
/// snapped to a power-of-two grid that the shared face, edge or corner defines. So there is nothing
/// to stitch, at any offset from the origin.
///
/// A pure function of its arguments: the same bytes on any thread.
/// Thread: any number at once; the scratch belongs to the calling thread.
///
/// Source: Scholz, Bender, Dachsbacher, "Real-time isosurface extraction with view-dependent level
/// of detail and applications", sections 3.2 and 3.3. Differs: exact borders, a generated table
/// with unambiguous sides, vertices kept 1/64 away from samples, caps.
class CellExtractor {
public:
    CellExtractor(
        std::shared_ptr<const fields::Field> field,
        hierarchy::Domain domain,
        ExtractionSettings settings);

    /// @param trace      if not null, receives the border vertices and the times
    /// @param cancelled  looked at between steps; if it becomes true, nothing is returned
    [[nodiscard]] std::optional<CellMesh> extract(
        const hierarchy::Tetrahedron& cell,
        CellTrace* trace = nullptr,
        const std::atomic<bool>* cancelled = nullptr) const;

    /// The same into a mesh whose memory is used again.
    /// @return false if cancelled; the mesh is then undefined
    bool extractInto(
        const hierarchy::Tetrahedron& cell,
        CellMesh& mesh,
        CellTrace* trace = nullptr,
        const std::atomic<bool>* cancelled = nullptr) const;

    /// True if the field's bounds prove that no triangle can arise in a box [field], for any filter
    /// radius up to that of a cell as large as the box.
    [[nodiscard]] bool provesEmpty(const core::Box& box) const
    {
        return provesEmpty(boundsOf(box));
    }
    /// The same in two steps: what is asked of the field once serves every isovalue.
    [[nodiscard]] BoxBounds boundsOf(const core::Box& box) const;
    [[nodiscard]] bool provesEmpty(const BoxBounds& bounds) const;

    [[nodiscard]] const hierarchy::Domain& domain() const { return _domain; }
    [[nodiscard]] const fields::Field& field() const { return *_field; }
    [[nodiscard]] const ExtractionSettings& settings() const { return _settings; }

private:
    /// The stages between contouring and normals.
    /// @return whether the scratch holds the normals of the vertices already
    bool polish(
        const hierarchy::Tetrahedron& cell,
        const CellGeometry& geometry,
        const CellFrame& frame,
        CellScratch& scratch,
        CellTrace* trace) const;

    std::shared_ptr<const fields::Field> _field;
    std::optional<core::Box> _dataBox;
    hierarchy::Domain _domain;
    ExtractionSettings _settings;
    const VolumeMesh* _volumeMesh;
};

} // namespace isofront::extractor
