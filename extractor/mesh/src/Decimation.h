#pragma once

#include "CellFrame.h"
#include "RoughMesh.h"

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <vector>

namespace isofront::extractor {

/// The sum of squared distances to planes, weighted by the areas of the triangles that they are of.
struct Quadric {
    /// Coefficients of xx, xy, xz, yy, yz, zz, x, y, z, 1.
    std::array<double, 10> c{};
    double weight = 0;

    /// Adds the plane through a triangle; one without area adds nothing.
    void addTriangle(const glm::dvec3& p, const glm::dvec3& q, const glm::dvec3& r);
    void add(const Quadric& other);
    /// The weighted sum at a point, never below zero.
    [[nodiscard]] double at(const glm::dvec3& p) const;
};

/// What decimation reuses from cell to cell.
struct DecimationScratch {
    static constexpr std::uint32_t kNone = 0xffffffffU;

    /// What collapsing a vertex would cost at best, once somebody has asked.
    struct Collapse {
        double error = 0;
        std::uint16_t target = kNoVertex; ///< kNoVertex: there is no legal collapse
        bool known = false;
    };

    std::vector<glm::dvec3> position; ///< [cell units] from the middle of the cell's box
    std::vector<Quadric> quadric;
    std::vector<double> own; ///< of a vertex: its quadric at its position
    std::vector<std::uint32_t> firstCorner;
    std::vector<std::uint32_t> nextCorner; ///< of the same vertex
    std::vector<std::uint8_t> gone;        ///< by triangle
    /// By triangle: the first of the removed vertices that lie nearest to it; and the next of
    /// those.
    std::vector<std::uint16_t> firstHeld;
    std::vector<std::uint16_t> nextHeld;
    std::vector<std::array<std::uint16_t, 2>> held;
    std::vector<Collapse> best;
    std::vector<std::uint16_t> active;   ///< vertices that may be collapsed, in any order
    std::vector<std::uint16_t> activeAt; ///< where a vertex stands in it, or kNoVertex
    std::vector<std::uint32_t> mark;
    std::uint32_t epoch = 0;
};

struct DecimationSettings {
    /// The root of the mean squared distance of a vertex from the planes of the triangles that it
    /// stands for is kept below this, and every removed vertex within twice this of a triangle
    /// [cell units].
    double tolerance = 0;
    int choices = 8;        ///< d: vertices drawn for one collapse
    std::uint64_t seed = 0; ///< from the cell's name, so that its mesh depends on nothing else
};

/// Removes vertices that hardly change the surface, until no legal collapse is left within the
/// tolerance.
///
/// A vertex is collapsed into a neighbour, so those that remain stay where they are. Border and cap
/// vertices stay, and so does every edge between two of them on the same face: no new edge joins
/// two vertices of one face, since the neighbour's mesh may have an edge between the same two. The
/// Euler number stays, and no triangle turns by more than 78 degrees or becomes a sliver.
///
/// Source: J. Wu and L. Kobbelt, "Fast mesh decimation by multiple-choice techniques" (2002).
/// Differs: vertices are drawn, not edges, and a vertex remembers its cheapest legal collapse until
/// something around it changes, so that the end is exact and not a matter of luck; random numbers
/// are a function of the cell's name and a counter.
/// Source: M. Garland and P. Heckbert, "Surface simplification using quadric error metrics" (1997).
///
/// Cost: about a microsecond a collapse; allocates only where the scratch is too small.
void decimate(
    RoughMesh& mesh,
    const CellFrame& frame,
    const DecimationSettings& settings,
    DecimationScratch& scratch);

} // namespace isofront::extractor
