// Fractal noise over axis-aligned grids, for each instruction set, bit for bit as at single points.
//
// The noise of a point is interpolated between its cell's eight corners, each of which gives the
// dot product of its gradient with the way to the point. Along a row of a grid y and z are fixed;
// so for a corner that is S u + C, with u the way along x and S one of 0, 1 and -1. Corners are
// hashed once a lattice plane, their C computed once a row, and what is left for a sample are eight
// products with S, which are exact, and the interpolation. No sum is taken in another order than at
// a single point, so no bit differs.

#if defined(ISOFRONT_FIELDS_NOISE_GRID_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef ISOFRONT_FIELDS_NOISE_GRID_INL_H
#undef ISOFRONT_FIELDS_NOISE_GRID_INL_H
#else
#define ISOFRONT_FIELDS_NOISE_GRID_INL_H
#endif

#include "isofront/fields/Field.h"
#include "simd/Batch-inl.h"
#include "simd/Noise-inl.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

/// A whole number of vectors, and room for a vector that starts at any of `count` places.
constexpr std::size_t paddedCount(std::size_t count)
{
    return (count + kLanes - 1) / kLanes * kLanes;
}
constexpr std::size_t roomFor(std::size_t count)
{
    return paddedCount(count) + kLanes;
}

/// `cellOf` for one coordinate.
struct Place {
    std::uint32_t index;
    float centred;
};
inline Place placeOf(double p, double frequency, double offset)
{
    constexpr double kMagic = 6755399441055744.0;
    const double t = p * frequency + offset;
    const double moved = t + kMagic;
    return {
        static_cast<std::uint32_t>(std::bit_cast<std::uint64_t>(moved)),
        static_cast<float>(t - (moved - kMagic))};
}

/// The places of samples along one axis.
inline std::vector<Place>
placesOf(const std::vector<double>& coordinates, double frequency, double offset)
{
    std::vector<Place> places;
    places.reserve(coordinates.size());
    for (const double p : coordinates)
        places.push_back(placeOf(p, frequency, offset));
    return places;
}

/// Corners i of a lattice, one after the other, in a row of j.
inline std::size_t cornersOver(const std::vector<Place>& places)
{
    // Differences of 32 bits are right although the indices themselves wrap.
    return std::size_t{places.back().index - places.front().index} + 2;
}

/// Where one coordinate of a sample lies in its cell, from the corners on both sides.
struct Way {
    float near;
    float far;
    float faded;
};
inline Way wayOf(const Place& place)
{
    return {place.centred + 0.5F, place.centred - 0.5F, hn::GetLane(fade(constant(place.centred)))};
}

/// Numbers of the corners to the left and to the right of each sample of a group.
struct CornerPair {
    Floats left;
    Floats right;
};

/// What a row of samples needs to know along x, for one octave; the same in every row.
class RowPlan {
public:
    explicit RowPlan(const std::vector<Place>& places)
        : _first(places.front().index), _corners(cornersOver(places)),
          _groups(paddedCount(places.size()) / kLanes)
    {
        for (std::size_t i = 0; i < _groups.size(); ++i) {
            Group& group = _groups[i];
            group.base = places[i * kLanes].index - _first;
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const Place& place = places[std::min(i * kLanes + lane, places.size() - 1)];
                const Way way = wayOf(place);
                group.near[lane] = way.near;
                group.far[lane] = way.far;
                group.faded[lane] = way.faded;
                group.left[lane] = place.index - _first - group.base;
                group.right[lane] = group.left[lane] + 1;
                group.widest = std::max(group.widest, group.left[lane]);
            }
        }
    }

    /// Of the leftmost corner.
    [[nodiscard]] std::uint32_t first() const { return _first; }
    [[nodiscard]] std::size_t corners() const { return _corners; }

    /// A group of samples.
    struct Group {
        float near[kLanes]; ///< from the corner to the left, of each sample [cells]
        float far[kLanes];
        float faded[kLanes];
        std::uint32_t left[kLanes]; ///< corner to the left, counted from the base
        std::uint32_t right[kLanes];
        std::uint32_t base = 0;   ///< corner left of the first sample
        std::uint32_t widest = 0; ///< the largest of `left`

        /// Calls `body(lookup)` with what brings the numbers of corners to the samples.
        template <typename Body>
        HWY_INLINE Floats withLookup(const Body& body) const
        {
            const FloatTag f;
            // Most groups of long waves have one cell.
            if (widest == 0)
                return body([&](const float* numbers) HWY_ATTR {
                    return CornerPair{hn::Set(f, numbers[base]), hn::Set(f, numbers[base + 1])};
                });
            if (widest + 1 < kLanes) {
                const auto toLeft = hn::IndicesFromVec(f, hn::LoadU(WordTag(), left));
                const auto toRight = hn::IndicesFromVec(f, hn::LoadU(WordTag(), right));
                return body([&](const float* numbers) HWY_ATTR {
                    const Floats all = hn::LoadU(f, numbers + base);
                    return CornerPair{
                        hn::TableLookupLanes(all, toLeft), hn::TableLookupLanes(all, toRight)};
                });
            }
            return body([&](const float* numbers) HWY_ATTR {
                float all[2][kLanes];
                for (std::size_t lane = 0; lane < kLanes; ++lane) {
                    all[0][lane] = numbers[base + left[lane]];
                    all[1][lane] = numbers[base + right[lane]];
                }
                return CornerPair{hn::LoadU(f, all[0]), hn::LoadU(f, all[1])};
            });
        }
    };
    [[nodiscard]] const Group* groups() const { return _groups.data(); }

private:
    std::uint32_t _first;
    std::size_t _corners;
    std::vector<Group> _groups;
};

/// What the corners of a lattice carry: how many numbers, and what is made of them.
template <NoiseKind kKind>
struct CornerNumbers;

/// The four rows of corners about a row of samples, by steps in y and z, in this order: (0, 0),
/// (0, 1), (1, 0), (1, 1).
inline constexpr std::size_t kRowsAbout = 4;

template <>
struct CornerNumbers<NoiseKind::value> {
    static constexpr std::size_t kCount = 1;       ///< the value
    static constexpr std::size_t kCountOfRows = 0; ///< nothing to compute for a row

    static HWY_INLINE void store(Words axes, float* const* to, std::size_t at)
    {
        hn::StoreU(cornerValue(axes), FloatTag(), to[0] + at);
    }
    static HWY_INLINE Floats
    constants(const float* const* /*corners*/, Floats /*y*/, Floats /*z*/, std::size_t /*at*/)
    {
        return hn::Zero(FloatTag());
    }
    template <typename Lookup>
    static HWY_INLINE Floats alongX(
        const Lookup& lookup,
        const float* values,
        const float* /*constants*/,
        Floats /*near*/,
        Floats /*far*/,
        Floats faded)
    {
        const CornerPair value = lookup(values);
        return lerp(value.left, value.right, faded);
    }
    static HWY_INLINE Floats noise(Floats mixed)
    {
        return hn::Mul(constant(Noise<NoiseKind::value>::kScale), mixed);
    }
};

template <>
struct CornerNumbers<NoiseKind::gradient> {
    static constexpr std::size_t kCount = 3; ///< the gradient: 0, 1 or -1 along each axis
    static constexpr std::size_t kCountOfRows = kRowsAbout;

    static HWY_INLINE void store(Words axes, float* const* to, std::size_t at)
    {
        const Floats zero = hn::Zero(FloatTag());
        Floats gradient[3] = {zero, zero, zero};
        EdgeGradient(finished(axes)).addTo(gradient, constant(1.0F));
        for (std::size_t i = 0; i < 3; ++i)
            hn::StoreU(gradient[i], FloatTag(), to[i] + at);
    }
    /// What the dot product has along y and z. Two of the three numbers are not zero, so at most
    /// one sum is rounded, here or along x: that of EdgeGradient::dot.
    static HWY_INLINE Floats
    constants(const float* const* corners, Floats y, Floats z, std::size_t at)
    {
        const FloatTag f;
        return hn::MulAdd(
            hn::LoadU(f, corners[1] + at), y, hn::Mul(hn::LoadU(f, corners[2] + at), z));
    }
    template <typename Lookup>
    static HWY_INLINE Floats alongX(
        const Lookup& lookup,
        const float* slopes,
        const float* constants,
        Floats near,
        Floats far,
        Floats faded)
    {
        const CornerPair slope = lookup(slopes);
        const CornerPair rest = lookup(constants);
        return lerp(
            hn::MulAdd(slope.left, near, rest.left),
            hn::MulAdd(slope.right, far, rest.right),
            faded);
    }
    static HWY_INLINE Floats noise(Floats mixed) { return mixed; }
};

/// Numbers of a plane of lattice corners: some arrays, each in rows of i. Rows are filled as they
/// are needed.
template <NoiseKind kKind>
class CornerPlane {
public:
    using Corners = CornerNumbers<kKind>;
    static constexpr std::size_t kCount = Corners::kCount;

    CornerPlane(std::size_t corners, std::size_t rows)
        : _stride(roomFor(corners)), _numbers(kCount * _stride * rows), _isFilled(rows, 0)
    {
    }

    /// Goes to another plane.
    void moveTo(std::uint32_t z)
    {
        _z = z;
        std::ranges::fill(_isFilled, char(0));
    }

    struct Row {
        float* of[kCount];
    };
    /// @param first  the lattice corner at which rows begin, along x and y
    HWY_INLINE Row row(std::size_t j, const std::uint32_t (&first)[2], std::uint32_t seed)
    {
        Row row{};
        for (std::size_t i = 0; i < kCount; ++i)
            row.of[i] = _numbers.data() + (j * kCount + i) * _stride;
        if (_isFilled[j] == 0) {
            fill(row, first[0], first[1] + static_cast<std::uint32_t>(j), seed);
            _isFilled[j] = 1;
        }
        return row;
    }
    /// In whole vectors; what is beyond the last corner is never looked at.
    [[nodiscard]] std::size_t length() const { return _stride - kLanes; }

private:
    void fill(const Row& row, std::uint32_t firstX, std::uint32_t y, std::uint32_t seed) const
    {
        const WordTag w;
        const Words hashYz = hn::Xor(hashedY(hn::Set(w, y), seed), hashedZ(hn::Set(w, _z), seed));
        for (std::size_t at = 0; at < length(); at += kLanes) {
            const Words hashX = hashedX(hn::Iota(w, firstX + static_cast<std::uint32_t>(at)), seed);
            Corners::store(hn::Xor(hashX, hashYz), row.of, at);
        }
    }

    std::size_t _stride;
    std::vector<float> _numbers;
    std::vector<char> _isFilled;
    std::uint32_t _z = 0;
};

/// One octave over a block of a grid whose steps are no longer than a cell.
template <NoiseKind kKind>
class CoherentOctave {
public:
    CoherentOctave(
        const SpaceOctave& octave, const std::vector<double>& x, const std::vector<double>& y)
        : _octave(octave), _plan(placesOf(x, octave.frequency[0], octave.offset[0])),
          _y(placesOf(y, octave.frequency[1], octave.offset[1])),
          _low(_plan.corners(), cornersOver(_y)),
          _high(_low), _first{_plan.first(), _y.front().index}, _stride(roomFor(_plan.corners())),
          _constants(Corners::kCountOfRows * _stride)
    {
        for (const Place& place : _y)
            _waysOfY.push_back(wayOf(place));
    }

    /// Goes to a slice of the grid.
    void startSlice(double z)
    {
        const Place place = placeOf(z, _octave.frequency[2], _octave.offset[2]);
        if (!_isPlaced || place.index != _index) {
            if (_isPlaced && place.index == _index + 1)
                std::swap(_low, _high);
            else
                _low.moveTo(place.index);
            _high.moveTo(place.index + 1);
            _index = place.index;
            _isPlaced = true;
        }
        _wayOfZ = wayOf(place);
    }

    /// The noise of a row's samples.
    class Row {
    public:
        [[nodiscard]] HWY_INLINE Value noise(std::size_t index) const
        {
            const RowPlan::Group& group = groups[index];
            const FloatTag f;
            const Floats near = hn::LoadU(f, group.near);
            const Floats far = hn::LoadU(f, group.far);
            const Floats faded = hn::LoadU(f, group.faded);
            return {group.withLookup([&](const auto& lookup) HWY_ATTR {
                Floats alongX[kRowsAbout];
                for (std::size_t i = 0; i < kRowsAbout; ++i)
                    alongX[i] = Corners::alongX(lookup, corners[i], constants[i], near, far, faded);
                return Corners::noise(lerp(
                    lerp(alongX[0], alongX[2], fadedY),
                    lerp(alongX[1], alongX[3], fadedY),
                    fadedZ));
            })};
        }

        const RowPlan::Group* groups;
        const float* corners[kRowsAbout];   ///< what is looked up of the corners themselves
        const float* constants[kRowsAbout]; ///< C, of the four rows
        Floats fadedY;
        Floats fadedZ;
    };

    /// Goes to a row of the slice.
    HWY_INLINE Row startRow(std::size_t index)
    {
        const Way& wayOfY = _waysOfY[index];
        Row row{_plan.groups(), {}, {}, constant(wayOfY.faded), constant(_wayOfZ.faded)};
        const std::size_t j = _y[index].index - _y.front().index;
        const Floats y[2] = {constant(wayOfY.near), constant(wayOfY.far)};
        const Floats z[2] = {constant(_wayOfZ.near), constant(_wayOfZ.far)};
        for (std::size_t i = 0; i < kRowsAbout; ++i) {
            auto& plane = i % 2 == 0 ? _low : _high;
            const auto corners = plane.row(j + i / 2, _first, _octave.seed);
            row.corners[i] = corners.of[0];
            if constexpr (Corners::kCountOfRows > 0) {
                float* const to = _constants.data() + i * _stride;
                for (std::size_t at = 0; at + kLanes < _stride; at += kLanes)
                    hn::StoreU(
                        Corners::constants(corners.of, y[i / 2], z[i % 2], at),
                        FloatTag(),
                        to + at);
                row.constants[i] = to;
            }
        }
        return row;
    }

private:
    using Corners = CornerNumbers<kKind>;

    SpaceOctave _octave;
    RowPlan _plan;
    std::vector<Place> _y;
    std::vector<Way> _waysOfY;
    CornerPlane<kKind> _low;  ///< the lattice plane below the slice
    CornerPlane<kKind> _high; ///< and above
    std::uint32_t _first[2];  ///< the corner at which both begin
    std::size_t _stride;
    std::vector<float> _constants; ///< C, of the four rows
    Way _wayOfZ{};
    std::uint32_t _index = 0; ///< of the lattice plane below
    bool _isPlaced = false;
};

/// One octave, sample by sample: where the grid is so coarse that nearly every sample has a cell of
/// its own.
template <NoiseKind kKind>
class ScatteredOctave {
public:
    ScatteredOctave(
        const SpaceOctave& octave, const std::vector<double>& x, const std::vector<double>& y)
        : _octave(octave), _x(x), _y(y)
    {
        _x.resize(paddedCount(x.size()), x.back());
    }

    void startSlice(double z) { _z = z; }

    struct Row {
        const SpaceOctave* octave;
        const double* x;
        double y;
        double z;

        [[nodiscard]] HWY_INLINE Value noise(std::size_t group) const
        {
            const DoubleTag d;
            const Doubles atY = hn::Set(d, y);
            const Doubles atZ = hn::Set(d, z);
            const Point<Value> p{{loaded(x + group * kLanes)}, {{atY, atY}}, {{atZ, atZ}}};
            return calledNoise<kKind>(*octave, p);
        }
    };
    [[nodiscard]] Row startRow(std::size_t row) const { return {&_octave, _x.data(), _y[row], _z}; }

private:
    SpaceOctave _octave;
    std::vector<double> _x;
    std::vector<double> _y;
    double _z = 0;
};

/// A fractal sum over a grid. A sample's value depends on nothing but its place, and on the spacing
/// of the grid.
template <NoiseKind kKind, FractalKind kFractal>
class GridSampler {
public:
    GridSampler(std::span<const SpaceOctave> octaves, const SampleGrid& grid) : _grid(grid)
    {
        const Floats radius = constant(static_cast<float>(grid.radius));
        for (const SpaceOctave& octave : octaves) {
            const Value factor = weight<Value>({radius, radius}, octave.filterCycles);
            if (!vanishes(factor))
                _octaves.push_back({octave, hn::GetLane(factor.v)});
        }
    }

    void sample(float* values) const
    {
        // Small enough that sums and lattice planes stay in the cache.
        constexpr std::int64_t kMostX = 256;
        constexpr std::int64_t kMostY = 64;
        for (std::int64_t y = 0; y < _grid.count.y; y += kMostY)
            for (std::int64_t x = 0; x < _grid.count.x; x += kMostX)
                sampleColumn(
                    x,
                    y,
                    std::min(kMostX, _grid.count.x - x),
                    std::min(kMostY, _grid.count.y - y),
                    values);
    }

private:
    struct WeightedOctave {
        SpaceOctave octave;
        float factor;
    };
    /// What has been summed up at the samples of a slice.
    struct Sums {
        std::vector<float> sum;
        std::vector<float> carrier;
    };

    [[nodiscard]] std::vector<double>
    coordinates(glm::length_t axis, std::int64_t first, std::int64_t count) const
    {
        std::vector<double> result;
        result.reserve(static_cast<std::size_t>(count));
        for (std::int64_t i = 0; i < count; ++i) {
            const std::int64_t index = _grid.first[axis] + first + i;
            result.push_back(_grid.origin[axis] + _grid.spacing * static_cast<double>(index));
        }
        return result;
    }

    /// All slices of a part of the rows.
    void sampleColumn(
        std::int64_t firstX,
        std::int64_t firstY,
        std::int64_t countX,
        std::int64_t countY,
        float* values) const
    {
        if (_grid.count.z <= 0)
            return;
        const std::vector<double> x = coordinates(0, firstX, countX);
        const std::vector<double> y = coordinates(1, firstY, countY);
        const std::vector<double> z = coordinates(2, 0, _grid.count.z);
        std::vector<CoherentOctave<kKind>> coherent;
        std::vector<ScatteredOctave<kKind>> scattered;
        for (const WeightedOctave& weighted : _octaves) {
            if (isCoherent(weighted.octave))
                coherent.emplace_back(weighted.octave, x, y);
            else
                scattered.emplace_back(weighted.octave, x, y);
        }
        const std::size_t stride = paddedCount(x.size());
        Sums sums{std::vector<float>(stride * y.size()), {}};
        for (std::size_t k = 0; k < z.size(); ++k) {
            std::ranges::fill(sums.sum, 0.0F);
            if constexpr (kFractal == FractalKind::ridged)
                sums.carrier.assign(sums.sum.size(), 1.0F);
            auto nextCoherent = coherent.begin();
            auto nextScattered = scattered.begin();
            for (const WeightedOctave& weighted : _octaves) {
                if (isCoherent(weighted.octave))
                    add(weighted, *nextCoherent++, z[k], y.size(), stride, sums);
                else
                    add(weighted, *nextScattered++, z[k], y.size(), stride, sums);
            }
            for (std::size_t j = 0; j < y.size(); ++j) {
                const std::size_t row = (k * static_cast<std::size_t>(_grid.count.y) +
                                         static_cast<std::size_t>(firstY) + j) *
                                        static_cast<std::size_t>(_grid.count.x);
                std::copy_n(
                    sums.sum.data() + j * stride,
                    x.size(),
                    values + row + static_cast<std::size_t>(firstX));
            }
        }
    }

    /// The octave's noise at all samples of a slice.
    template <typename Octave>
    void
    add(const WeightedOctave& weighted,
        Octave& octave,
        double z,
        std::size_t rows,
        std::size_t stride,
        Sums& sums) const
    {
        const FloatTag f;
        const Value factor = fromConstant<Value>(weighted.factor);
        octave.startSlice(z);
        for (std::size_t row = 0; row < rows; ++row) {
            const auto samples = octave.startRow(row);
            for (std::size_t at = 0; at < stride; at += kLanes) {
                float* const to = sums.sum.data() + row * stride + at;
                FractalSum<kFractal, Value> fractal{{hn::LoadU(f, to)}, fromConstant<Value>(1.0F)};
                if constexpr (kFractal == FractalKind::ridged)
                    fractal.carrier = {hn::LoadU(f, sums.carrier.data() + row * stride + at)};
                fractal.add(
                    samples.noise(at / kLanes),
                    weighted.octave.amplitude,
                    factor,
                    spaceNorms(kKind));
                hn::StoreU(fractal.sum.v, f, to);
                if constexpr (kFractal == FractalKind::ridged)
                    hn::StoreU(fractal.carrier.v, f, sums.carrier.data() + row * stride + at);
            }
        }
    }

    /// With less than a sample a cell there is nothing to share along a row.
    [[nodiscard]] bool isCoherent(const SpaceOctave& octave) const
    {
        return _grid.spacing * std::max(octave.frequency[0], octave.frequency[1]) <= 1.0;
    }

    SampleGrid _grid;
    std::vector<WeightedOctave> _octaves;
};

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
