#pragma once

#include "Interpolation.h"
#include "LevelAxis.h"
#include "MinMaxTree.h"
#include "TrilinearKernel.h"

#include <glm/vec3.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>
#include <vector>

namespace isofront::volume::detail {

// How the nodes of a level are kept: as codes, which stand for `low + step * code` with a step that
// is a power of two, or as floats.

/// Codes of 12 bits, two in three bytes: for volumes of 8 bits, which a level of 16 would make a
/// quarter larger on its own.
class TwelveBitCodes {
public:
    using Value = std::uint16_t;
    static constexpr NodeType kNodeType = NodeType::codes12;
    static constexpr int kMostCode = 4095;
    static constexpr int kTogether = 2; ///< a row begins where codes begin with a byte

    explicit TwelveBitCodes(std::size_t count) : _bytes((3 * count + 1) / 2 + kPadding) {}

    void set(std::size_t i, Value code)
    {
        std::uint8_t* const byte = &_bytes[3 * i / 2];
        if (i % 2 == 0) {
            byte[0] = static_cast<std::uint8_t>(code);
            byte[1] = static_cast<std::uint8_t>((byte[1] & 0xF0U) | std::uint32_t{code} >> 8U);
        } else {
            byte[0] = static_cast<std::uint8_t>((byte[0] & 0x0FU) | std::uint32_t{code} << 4U);
            byte[1] = static_cast<std::uint8_t>(std::uint32_t{code} >> 4U);
        }
    }
    [[nodiscard]] Value at(std::size_t i) const { return static_cast<Value>(from(i) & 0xFFFU); }
    [[nodiscard]] const void* data() const { return _bytes.data(); }
    [[nodiscard]] std::size_t bytes() const { return _bytes.size(); }

private:
    static constexpr std::size_t kPadding = 4; ///< four bytes are read at once

    /// From the lowest bit of code i on.
    [[nodiscard]] std::uint32_t from(std::size_t i) const
    {
        const std::uint8_t* const b = &_bytes[3 * i / 2];
        const std::uint32_t word = std::uint32_t{b[0]} | std::uint32_t{b[1]} << 8U |
                                   std::uint32_t{b[2]} << 16U | std::uint32_t{b[3]} << 24U;
        return word >> (i % 2 * 4U);
    }

    std::vector<std::uint8_t> _bytes;
};

/// Codes of 16 bits, or floats as they are.
template <typename V>
class WholeCodes {
public:
    using Value = V;
    static constexpr NodeType kNodeType =
        std::is_floating_point_v<V> ? NodeType::float32 : NodeType::codes16;
    static constexpr int kMostCode = 65535;
    static constexpr int kTogether = 1;

    explicit WholeCodes(std::size_t count) : _values(count) {}

    void set(std::size_t i, Value value) { _values[i] = value; }
    [[nodiscard]] Value at(std::size_t i) const { return _values[i]; }
    [[nodiscard]] const void* data() const { return _values.data(); }
    [[nodiscard]] std::size_t bytes() const { return _values.size() * sizeof(Value); }

private:
    std::vector<Value> _values;
};

/// What keeps the levels of a volume of T: half as much again for 8 bits, the same for others, and
/// float for what is converted to it in the end.
template <typename T>
using CodesOf = std::conditional_t<
    std::is_integral_v<T> && sizeof(T) == 1,
    TwelveBitCodes,
    std::conditional_t<
        std::is_integral_v<T> && sizeof(T) == 2,
        WholeCodes<std::uint16_t>,
        WholeCodes<float>>>;

/// The values that codes stand for.
struct CodeScale {
    double low = 0;
    double step = 1;

    /// The finest scale for values in [low, high].
    static CodeScale over(double low, double high, int mostCode)
    {
        CodeScale scale{low, 0x1p-16};
        while ((high - low) > scale.step * mostCode)
            scale.step *= 2;
        return scale;
    }
};

/// One level of a pyramid. Its coordinates are those of the volume.
///
/// Thread: any number of readers.
template <typename Codes>
class LevelGrid {
public:
    using Value = typename Codes::Value;
    /// Not codes, but values themselves.
    static constexpr bool kIsPlain = std::is_floating_point_v<Value>;

    /// @param voxels  size of the volume
    /// @param level   at least 1
    /// @param scale   that all values will fit; not looked at for floats
    LevelGrid(const glm::ivec3& voxels, int level, const CodeScale& scale) : _scale(scale)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const LevelAxis along(voxels[axis], level);
            _size[axis] = along.nodes;
            _axes[axis] = {
                .limit = static_cast<double>(voxels[axis] - 1),
                .scale = along.scale,
                .lastCell = std::max(along.nodes - 2, 0),
                .lastRatio = along.lastRatio};
        }
        _rowNodes = (_size.x + Codes::kTogether - 1) / Codes::kTogether * Codes::kTogether;
        _codes = std::make_unique<Codes>(
            static_cast<std::size_t>(_rowNodes) * static_cast<std::size_t>(_size.y) *
            static_cast<std::size_t>(_size.z));
    }

    [[nodiscard]] const glm::ivec3& size() const { return _size; }

    [[nodiscard]] Value at(int x, int y, int z) const
    {
        return _codes->at(rowIndex(y, z) + static_cast<std::size_t>(x));
    }

    const Value* row(int y, int z, std::vector<Value>& scratch) const
    {
        const std::size_t begin = rowIndex(y, z);
        scratch.resize(static_cast<std::size_t>(_size.x));
        for (std::size_t i = 0; i < scratch.size(); ++i)
            scratch[i] = _codes->at(begin + i);
        return scratch.data();
    }

    /// The values along a row.
    void valuesInto(int y, int z, double* out) const
    {
        const std::size_t begin = rowIndex(y, z);
        for (std::size_t i = 0; i < static_cast<std::size_t>(_size.x); ++i)
            out[i] = valueOf(_codes->at(begin + i));
    }

    void setRow(int y, int z, const double* values)
    {
        const std::size_t begin = rowIndex(y, z);
        for (std::size_t i = 0; i < static_cast<std::size_t>(_size.x); ++i) {
            if constexpr (kIsPlain)
                _codes->set(begin + i, static_cast<float>(values[i]));
            else
                _codes->set(
                    begin + i, static_cast<Value>((values[i] - _scale.low) / _scale.step + 0.5));
        }
    }

    /// To be called when all rows are there.
    void finish() { _tree = std::make_unique<const MinMaxTree<LevelGrid>>(*this); }

    /// As the kernel sees it.
    [[nodiscard]] NodeGrid nodes() const
    {
        return {
            .nodes = _codes->data(),
            .type = Codes::kNodeType,
            .size = _size,
            .row = _rowNodes,
            .slice = std::int64_t{_rowNodes} * _size.y,
            .axes = _axes,
            .low = _scale.low,
            .step = _scale.step};
    }

    /// What holds every sample at the points of a box, clamped to the volume.
    [[nodiscard]] core::Interval bounds(const core::Box& box) const
    {
        glm::ivec3 first;
        glm::ivec3 last;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const auto& [limit, scale, lastCell, lastRatio] = _axes[axis];
            const double low = clampedTo(0.0, limit, box.low[axis]) * scale;
            const double high = clampedTo(0.0, limit, box.high[axis]) * scale;
            first[axis] = static_cast<int>(low);
            last[axis] = std::max(first[axis], static_cast<int>(std::ceil(high)) - 1);
        }
        return valuesOf(_tree->extremes(*this, first, last));
    }
    /// The same for the whole volume.
    [[nodiscard]] core::Interval bounds() const { return valuesOf(_tree->all()); }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        return _codes->bytes() + _tree->memoryBytes();
    }

private:
    [[nodiscard]] std::size_t rowIndex(int y, int z) const
    {
        return (static_cast<std::size_t>(z) * static_cast<std::size_t>(_size.y) +
                static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(_rowNodes);
    }

    [[nodiscard]] double valueOf(Value code) const
    {
        if constexpr (kIsPlain)
            return static_cast<double>(code);
        else
            return _scale.low + _scale.step * static_cast<double>(code);
    }

    [[nodiscard]] core::Interval valuesOf(const Extremes<Value>& extremes) const
    {
        if constexpr (kIsPlain) {
            return extremes.samples();
        } else {
            // Codes are interpolated in float. What comes of them never exceeds the greatest, which
            // as a number of 16 bits is even in the last place of float, nor falls below 0; but
            // each of three steps may lose half a unit in the last place of the greatest.
            const double rounding = 0x1p-22 * _scale.step * static_cast<double>(extremes.high);
            return {std::max(_scale.low, valueOf(extremes.low) - rounding), valueOf(extremes.high)};
        }
    }

    glm::ivec3 _size{0};
    int _rowNodes = 0; ///< from row to row
    CodeScale _scale;
    std::array<AxisCells, 3> _axes;
    std::unique_ptr<Codes> _codes;
    std::unique_ptr<const MinMaxTree<LevelGrid>> _tree;
};

} // namespace isofront::volume::detail
