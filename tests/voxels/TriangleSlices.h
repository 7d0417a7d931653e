#pragma once

#include "LatticeTriangle.h"

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace isofront::voxels {

/// The piece of a triangle that lies in a voxel: a convex polygon.
struct Piece {
    /// Corners: three, one for each face of the cube, and some for polygons that rounding bends.
    static constexpr std::size_t kMost = 16;

    std::array<glm::dvec3, kMost> corners;
    std::size_t count = 0;
    bool touching = false; ///< its area, if it has any, counts in the next voxel

    Piece() = default;
    ~Piece() = default;
    /// Copies the corners that there are: most pieces have few.
    Piece(const Piece& other) { *this = other; }
    Piece& operator=(const Piece& other)
    {
        if (this != &other) {
            count = other.count;
            touching = other.touching;
            std::copy_n(other.corners.begin(), count, corners.begin());
        }
        return *this;
    }

    void add(const glm::dvec3& corner)
    {
        if (count < kMost)
            corners[count++] = corner;
    }
    struct Mass {
        double area = 0;        ///< along the normal given
        glm::dvec3 centroid{0}; ///< of the area; without any, of the corners
    };
    /// @param normal  unit normal of the triangle
    [[nodiscard]] Mass mass(const glm::dvec3& normal) const
    {
        glm::dvec3 sum(0);
        double area = 0;
        for (std::size_t i = 2; i < count && !touching; ++i) {
            const glm::dvec3 u = corners[i - 1] - corners[0];
            const glm::dvec3 v = corners[i] - corners[0];
            const double part = 0.5 * glm::dot(glm::cross(u, v), normal);
            sum += part * (u + v);
            area += part;
        }
        if (area > 0)
            return {area, corners[0] + sum / (3 * area)};
        sum = glm::dvec3(0);
        for (std::size_t i = 0; i < count; ++i)
            sum += corners[i];
        return {0, sum / static_cast<double>(count)};
    }
};

namespace slicing {

/// Voxels that a triangle may touch but for rounding are visited, too [voxels].
inline constexpr double kSlack = 1e-7;

/// Divides a piece by a plane across an axis. Both parts keep the corners on the plane.
inline void divide(const Piece& piece, std::size_t axis, double plane, Piece& below, Piece& above)
{
    below.count = 0;
    above.count = 0;
    below.touching = piece.touching;
    above.touching = piece.touching;
    for (std::size_t i = 0; i < piece.count; ++i) {
        const glm::dvec3& here = piece.corners[i];
        const glm::dvec3& next = piece.corners[i + 1 < piece.count ? i + 1 : 0];
        const double a = here[axis] - plane;
        const double b = next[axis] - plane;
        if (a <= 0)
            below.add(here);
        if (a >= 0)
            above.add(here);
        if ((a < 0 && b > 0) || (a > 0 && b < 0)) {
            glm::dvec3 cut = here + (next - here) * (a / (a - b));
            cut[axis] = plane;
            below.add(cut);
            above.add(cut);
        }
    }
}

/// The corners of a piece that lie on a plane, but for the slack.
inline Piece touched(const Piece& piece, std::size_t axis, double plane)
{
    Piece part;
    part.touching = true;
    for (std::size_t i = 0; i < piece.count; ++i)
        if (std::abs(piece.corners[i][axis] - plane) <= kSlack)
            part.add(piece.corners[i]);
    return part;
}

/// Calls `body(k, piece)` for each layer across an axis that a piece meets. Uses the piece up.
template <typename Body>
void forEachLayer(
    Piece& piece, std::size_t axis, std::int64_t low, std::int64_t high, const Body& body)
{
    double least = piece.corners[0][axis];
    double most = least;
    for (std::size_t i = 1; i < piece.count; ++i) {
        least = std::min(least, piece.corners[i][axis]);
        most = std::max(most, piece.corners[i][axis]);
    }
    auto k = static_cast<std::int64_t>(std::floor(least - kSlack));
    const auto last = static_cast<std::int64_t>(std::floor(most + kSlack));
    if (last < low || k >= high)
        return;
    Piece below;
    Piece above;
    if (k < low) {
        divide(piece, axis, static_cast<double>(low), below, above);
        if (above.count == 0) // it ends within the slack
            above = touched(piece, axis, static_cast<double>(low));
        piece = above;
        k = low;
    }
    for (; k < last && k < high; ++k) {
        const auto plane = static_cast<double>(k + 1);
        if (least >= plane) { // only touched from above, where all of it lies
            below = touched(piece, axis, plane);
            body(k, below);
        } else if (most > plane) {
            divide(piece, axis, plane, below, above);
            body(k, below);
            piece = above;
        } else { // the next layer is only touched
            above = touched(piece, axis, plane);
            body(k, piece);
            piece = above;
        }
    }
    if (k < high)
        body(k, piece);
}

} // namespace slicing

/// Cuts a triangle into its pieces by voxel.
///
/// Every voxel that the triangle touches is visited once, and hardly another; one that it only
/// touches gets a piece without area. The pieces' areas add up to the triangle's, to within
/// rounding. The work is that of the pieces, not that of all voxels around the triangle.
///
/// @param corners  [voxels]
/// @param within   other voxels are left out
/// @param body     called with (x, y, z, piece)
template <typename Body>
void forEachPiece(
    const std::array<glm::dvec3, 3>& corners, const VoxelRange& within, const Body& body)
{
    Piece whole;
    for (const glm::dvec3& corner : corners)
        whole.add(corner);
    slicing::forEachLayer(
        whole, 2, within.low[2], within.high[2], [&](std::int64_t z, Piece& slab) {
            slicing::forEachLayer(
                slab, 1, within.low[1], within.high[1], [&](std::int64_t y, Piece& bar) {
                    slicing::forEachLayer(
                        bar, 0, within.low[0], within.high[0], [&](std::int64_t x, Piece& piece) {
                            body(x, y, z, piece);
                        });
                });
        });
}

} // namespace isofront::voxels
