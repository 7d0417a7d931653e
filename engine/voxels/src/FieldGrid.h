#pragma once

#include <isofront/voxels/FieldVoxelization.h>

#include <glm/mat3x3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace isofront::voxels {

/// A place on the lattice in halves of a voxel: the low corner of voxel i is 2i, its middle 2i + 1.
using HalfPlace = std::array<std::int64_t, 3>;

/// Voxels of a lattice along each axis: as many as the box needs, but for rounding.
std::array<std::uint32_t, 3> voxelCounts(const FieldVoxelizationSettings& settings);

/// Points of a field, as structure of arrays [field].
struct FieldPoints {
    std::vector<double> x, y, z;
    std::vector<double> radius; ///< used by those who sample

    void clear();
    void add(const glm::dvec3& point);
    [[nodiscard]] std::size_t size() const { return x.size(); }
};

/// A field on the lattice of its voxels. What it says of a place depends on that place only, never
/// on what else is asked for: so chunks agree where they meet, to the last bit.
///
/// Thread: any number at once, each with points of its own.
class FieldGrid {
public:
    FieldGrid(
        const fields::Field& field,
        const FieldVoxelizationSettings& settings,
        const VoxelLattice& lattice);

    /// Voxels along each axis.
    [[nodiscard]] const std::array<std::int64_t, 3>& counts() const { return _counts; }
    [[nodiscard]] bool isColoured() const { return _field.hasAttributes(); }

    /// @param place  in halves of a voxel, as HalfPlace
    [[nodiscard]] glm::dvec3 fieldPoint(const glm::dvec3& place) const;
    [[nodiscard]] glm::dvec3 fieldPoint(const HalfPlace& place) const;

    /// True where the lattice has voxels and the field has data.
    [[nodiscard]] bool hasData(const HalfPlace& place) const;
    /// True if that is so everywhere between two places; false if it isn't, or can't be told.
    [[nodiscard]] bool hasDataBetween(const HalfPlace& low, const HalfPlace& high) const;
    /// True if that is so nowhere between two places; false if it isn't, or can't be told.
    [[nodiscard]] bool hasNoneBetween(const HalfPlace& low, const HalfPlace& high) const;
    /// The outward normal of the border of the data [world], seen from a place beyond it.
    [[nodiscard]] glm::dvec3 borderNormal(const HalfPlace& beyond) const;

    /// What the field says of its values between two places.
    [[nodiscard]] core::Interval bounds(const HalfPlace& low, const HalfPlace& high) const;
    /// Values at `low`, `low + 2` and so on along each axis up to `high`, x fastest.
    void sampleGrid(
        const HalfPlace& low,
        const HalfPlace& high,
        FieldPoints& points,
        std::vector<float>& values) const;
    void sample(FieldPoints& points, std::vector<float>& values) const;
    /// The steepest way down at points, so outward [world]; zero where there is none.
    void descents(FieldPoints& points, std::vector<glm::dvec3>& normals) const;
    void attributes(FieldPoints& points, std::vector<std::uint32_t>& words) const;

    [[nodiscard]] bool isInside(float value) const
    {
        return static_cast<double>(value) >= _isovalue;
    }
    [[nodiscard]] double isovalue() const { return _isovalue; }
    /// A value less the isovalue; of one that is not finite, or huge, something finite on its side.
    [[nodiscard]] double above(float value) const;

private:
    [[nodiscard]] fields::SampleBatch batch(FieldPoints& points) const;
    /// The box around a part of the lattice [field], a little wider than rounding could make it.
    [[nodiscard]] core::Box boxBetween(const HalfPlace& low, const HalfPlace& high) const;

    const fields::Field& _field;
    double _isovalue;
    glm::dvec3 _origin;
    double _half; ///< of a voxel's edge [world]
    core::Affine _fieldFromWorld;
    glm::dmat3 _worldFromGradient;
    double _radius;               ///< of the filter [field]
    double _slack;                ///< far more than rounding does, far less than a voxel [field]
    std::optional<double> _scale; ///< of the field's space by the world's, if all else is equal
    std::optional<core::Box> _data;
    std::array<std::int64_t, 3> _counts{};
};

} // namespace isofront::voxels
