#pragma once

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>

namespace isofront::voxels {

/// Voxels along a chunk's edge, at every level.
inline constexpr std::uint32_t kChunkEdge = 256;

/// The six directions across a voxel's faces, in the order of a face mask's bits.
enum class Face : std::uint8_t { lowX, highX, lowY, highY, lowZ, highZ };
inline constexpr std::size_t kFaces = 6;
/// The step across each face [voxels].
inline constexpr std::array<std::array<int, 3>, kFaces> kFaceSteps{
    {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// A mask with the bit of one face.
constexpr std::uint8_t faceBit(Face face)
{
    return static_cast<std::uint8_t>(1U << static_cast<unsigned>(face));
}
inline constexpr std::uint8_t kAllFaces = 0x3f;

/// A cube that the surface crosses, as it is stored: where in its chunk, which of its faces can be
/// seen from outside, and how the surface lies in it. Eight bytes.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 3.
struct Voxel {
    /// x, y and z in the chunk, 8 bits each, x lowest; then the face mask.
    std::uint32_t place = 0;
    /// The unit normal, outward: x, y and z as 10-bit integers from -511 to 511, x lowest.
    std::uint32_t normal = 0;

    [[nodiscard]] constexpr std::uint32_t x() const { return place & 0xffU; }
    [[nodiscard]] constexpr std::uint32_t y() const { return place >> 8U & 0xffU; }
    [[nodiscard]] constexpr std::uint32_t z() const { return place >> 16U & 0xffU; }
    [[nodiscard]] constexpr std::uint8_t faces() const
    {
        return static_cast<std::uint8_t>(place >> 24U & kAllFaces);
    }
    /// Its place in the order of a chunk: along x first, then y, then z.
    [[nodiscard]] constexpr std::uint32_t order() const { return place & 0xffffffU; }

    friend constexpr bool operator==(const Voxel&, const Voxel&) = default;
};
static_assert(sizeof(Voxel) == 8);

/// @param x, y, z  below kChunkEdge
constexpr std::uint32_t
packPlace(std::uint32_t x, std::uint32_t y, std::uint32_t z, std::uint8_t faces)
{
    return x | y << 8U | z << 16U | static_cast<std::uint32_t>(faces) << 24U;
}

/// The stored form of a direction of any length; of one without a length, or that is not finite,
/// straight up z. The error of an angle is below 0.12 degrees.
std::uint32_t packNormal(const glm::dvec3& direction);
/// What a stored normal says, of unit length.
glm::dvec3 unpackNormal(std::uint32_t packed);

} // namespace isofront::voxels
