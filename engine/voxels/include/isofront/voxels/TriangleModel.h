#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Image.h>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace isofront::voxels {

/// A picture that is laid over triangles.
struct Texture {
    /// What lies beyond its borders.
    enum class Wrap : std::uint8_t { repeat, clamp, mirror };

    core::Image image; ///< of one pixel at least
    Wrap acrossX = Wrap::repeat;
    Wrap acrossY = Wrap::repeat;
};

/// Of a triangle without a texture.
inline constexpr std::uint32_t kNoTexture = 0xffffffffU;

/// A mesh to be voxelised: what a file holds, in its own coordinates.
///
/// A triangle's colour is that of its positions times that of its texture; white where it has
/// neither.
struct TriangleModel {
    std::vector<glm::dvec3> positions; ///< [world]
    /// Of corners, counter-clockwise seen from outside.
    std::vector<std::array<std::uint32_t, 3>> triangles;
    /// 8-bit sRGB red, green, blue and opacity of each position, red lowest; or none at all.
    std::vector<std::uint32_t> colours;
    std::vector<Texture> textures;
    /// The texture of each triangle, or kNoTexture; or none at all.
    std::vector<std::uint32_t> textureOf;
    /// Where the corners of each triangle lie in its texture, from its left and from its top, whose
    /// width and height are 1; as many as `textureOf`.
    std::vector<std::array<glm::vec2, 3>> textureCorners;
    /// What of the file is not in the model, in sentences.
    std::vector<std::string> notes;

    [[nodiscard]] bool isColoured() const { return !colours.empty() || !textureOf.empty(); }
};

/// What is unusual in a model, and what voxelising makes of it.
struct ModelReport {
    std::uint64_t triangles = 0;
    std::uint64_t outOfRange = 0;       ///< name a position that isn't there: left out
    std::uint64_t notFinite = 0;        ///< have a corner that is not a finite number: left out
    std::uint64_t degenerate = 0;       ///< without area: they touch voxels, but separate nothing
    std::uint64_t openEdges = 0;        ///< of one triangle only: what they bound can be seen into
    std::uint64_t nonManifoldEdges = 0; ///< of more than two triangles
    std::uint64_t turnedEdges = 0;      ///< whose two triangles don't agree on what is outside
    core::Box bounds;                   ///< of all corners that are used [world]

    /// In sentences, for people; none for a model in order.
    [[nodiscard]] std::vector<std::string> notes() const;
};

/// Looks through a model. Equal positions count as one. Thread: any.
ModelReport inspect(const TriangleModel& model);

} // namespace isofront::voxels
