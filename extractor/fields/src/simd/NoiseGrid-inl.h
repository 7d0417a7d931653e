// Fractal noise over axis-aligned grids, for each instruction set.
//
// Along a row of a grid, with y and z fixed, noise in one cell of the lattice is
// lerp(H + G u, H' + G' (u - 1), fade(u)), where G and H belong to the corners left and right and
// are mixtures of their gradients over y and z. So corners are hashed once a lattice plane, mixed
// over z once a slice and over y once a row, and what is left for a sample is a dozen operations.

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

/// What a row of samples needs to know along x, for one octave; the same in every row.
class RowPlan {
public:
    explicit RowPlan(const std::vector<Place>& places)
        : _first(places.front().index), _corners(cornersOver(places))
    {
        const std::size_t room = paddedCount(places.size());
        _near.resize(room);
        _far.resize(room);
        _fade.resize(room);
        _within.resize(room);
        for (std::size_t begin = 0; begin < places.size(); begin += kLanes) {
            const std::uint32_t base = places[begin].index - _first;
            std::uint32_t widest = 0;
            for (std::size_t lane = 0; lane < kLanes; ++lane) {
                const Place& place = places[std::min(begin + lane, places.size() - 1)];
                const std::size_t to = begin + lane;
                _within[to] = place.index - _first - base;
                _near[to] = place.centred + 0.5F;
                _far[to] = place.centred - 0.5F;
                _fade[to] = place.centred;
                widest = std::max(widest, _within[to]);
            }
            const FloatTag f;
            hn::StoreU(fade(hn::LoadU(f, _fade.data() + begin)), f, _fade.data() + begin);
            _groups.push_back({base, widest});
        }
    }

    /// Of the leftmost corner.
    [[nodiscard]] std::uint32_t first() const { return _first; }
    [[nodiscard]] std::size_t corners() const { return _corners; }
    [[nodiscard]] std::size_t groups() const { return _groups.size(); }

    /// The noise of a group of samples from what its corners carry.
    template <bool kSloped>
    [[nodiscard]] HWY_INLINE Floats
    noise(std::size_t group, const float* constants, const float* slopes) const
    {
        const FloatTag f;
        const std::size_t at = group * kLanes;
        const Floats near = hn::LoadU(f, _near.data() + at);
        const Floats far = hn::LoadU(f, _far.data() + at);
        const Floats faded = hn::LoadU(f, _fade.data() + at);
        const Lookup lookup(*this, group);
        Floats left = lookup(constants);
        Floats right = lookup(constants + 1);
        if constexpr (kSloped) {
            left = hn::Add(left, hn::Mul(lookup(slopes), near));
            right = hn::Add(right, hn::Mul(lookup(slopes + 1), far));
        }
        return lerp(left, right, faded);
    }

private:
    struct Group {
        std::uint32_t base;   ///< corner left of the first sample
        std::uint32_t widest; ///< how many corners further right that of the last is
    };

    /// Brings the corners' numbers to the samples.
    class Lookup {
    public:
        HWY_INLINE Lookup(const RowPlan& plan, std::size_t group)
            : _group(plan._groups[group]), _within(plan._within.data() + group * kLanes)
        {
        }

        HWY_INLINE Floats operator()(const float* numbers) const
        {
            const FloatTag f;
            const float* const from = numbers + _group.base;
            if (_group.widest == 0)
                return hn::Set(f, *from);
            if (_group.widest < kLanes) {
                const auto indices = hn::IndicesFromVec(f, hn::LoadU(WordTag(), _within));
                return hn::TableLookupLanes(hn::LoadU(f, from), indices);
            }
            float all[kLanes];
            for (std::size_t lane = 0; lane < kLanes; ++lane)
                all[lane] = from[_within[lane]];
            return hn::LoadU(f, all);
        }

    private:
        Group _group;
        const std::uint32_t* _within;
    };

    std::uint32_t _first;
    std::size_t _corners;
    std::vector<float> _near; ///< from the corner to the left, of each sample [cells]
    std::vector<float> _far;
    std::vector<float> _fade;
    std::vector<std::uint32_t> _within; ///< corner to the left, counted from the group's base
    std::vector<Group> _groups;
};

/// What the corners of a lattice carry, in planes of z: how many numbers, and how they mix.
template <NoiseKind kKind>
struct CornerNumbers;

template <>
struct CornerNumbers<NoiseKind::value> {
    static constexpr std::size_t kCount = 1; ///< the value
    static constexpr bool kSloped = false;

    static HWY_INLINE void store(Words axes, float* const* to, std::size_t at)
    {
        hn::StoreU(
            hn::Mul(cornerValue(axes), constant(Noise<NoiseKind::value>::kScale)),
            FloatTag(),
            to[0] + at);
    }

    /// Mixes over z.
    /// @param centred, faded  of the slice
    static HWY_INLINE void mixOverZ(
        const float* const* low,
        const float* const* high,
        Floats /*centred*/,
        Floats faded,
        float* const* to,
        std::size_t at)
    {
        const FloatTag f;
        hn::StoreU(
            lerp(hn::LoadU(f, low[0] + at), hn::LoadU(f, high[0] + at), faded), f, to[0] + at);
    }

    /// Mixes over y.
    static HWY_INLINE void mixOverY(
        const float* const* low,
        const float* const* high,
        Floats /*centred*/,
        Floats faded,
        float* constants,
        float* /*slopes*/,
        std::size_t at)
    {
        const FloatTag f;
        hn::StoreU(
            lerp(hn::LoadU(f, low[0] + at), hn::LoadU(f, high[0] + at), faded), f, constants + at);
    }
};

template <>
struct CornerNumbers<NoiseKind::gradient> {
    static constexpr std::size_t kCount = 3; ///< the gradient; over z, the last is a constant
    static constexpr bool kSloped = true;

    static HWY_INLINE void store(Words axes, float* const* to, std::size_t at)
    {
        const Floats zero = hn::Zero(FloatTag());
        Floats gradient[3] = {zero, zero, zero};
        EdgeGradient(finished(axes)).addTo(gradient, constant(1.0F));
        for (std::size_t i = 0; i < 3; ++i)
            hn::StoreU(gradient[i], FloatTag(), to[i] + at);
    }

    static HWY_INLINE void mixOverZ(
        const float* const* low,
        const float* const* high,
        Floats centred,
        Floats faded,
        float* const* to,
        std::size_t at)
    {
        const FloatTag f;
        const Floats half = constant(0.5F);
        for (std::size_t i = 0; i < 2; ++i)
            hn::StoreU(
                lerp(hn::LoadU(f, low[i] + at), hn::LoadU(f, high[i] + at), faded), f, to[i] + at);
        const Floats fromLow = hn::Mul(hn::LoadU(f, low[2] + at), hn::Add(centred, half));
        const Floats fromHigh = hn::Mul(hn::LoadU(f, high[2] + at), hn::Sub(centred, half));
        hn::StoreU(lerp(fromLow, fromHigh, faded), f, to[2] + at);
    }

    static HWY_INLINE void mixOverY(
        const float* const* low,
        const float* const* high,
        Floats centred,
        Floats faded,
        float* constants,
        float* slopes,
        std::size_t at)
    {
        const FloatTag f;
        const Floats half = constant(0.5F);
        hn::StoreU(
            lerp(hn::LoadU(f, low[0] + at), hn::LoadU(f, high[0] + at), faded), f, slopes + at);
        const auto constantOf = [&](const float* const* row, Floats distance) HWY_ATTR {
            return hn::Add(hn::Mul(hn::LoadU(f, row[1] + at), distance), hn::LoadU(f, row[2] + at));
        };
        const Floats fromLow = constantOf(low, hn::Add(centred, half));
        const Floats fromHigh = constantOf(high, hn::Sub(centred, half));
        hn::StoreU(lerp(fromLow, fromHigh, faded), f, constants + at);
    }
};

/// Numbers of a plane of lattice corners: some arrays, each in rows of i.
template <std::size_t kCount>
class CornerPlane {
public:
    CornerPlane(std::size_t corners, std::size_t rows)
        : _stride(roomFor(corners)), _rows(rows), _numbers(kCount * _stride * rows)
    {
    }

    struct Row {
        float* of[kCount];
    };
    [[nodiscard]] HWY_INLINE Row row(std::size_t j)
    {
        Row row{};
        for (std::size_t i = 0; i < kCount; ++i)
            row.of[i] = _numbers.data() + (i * _rows + j) * _stride;
        return row;
    }
    /// In whole vectors; what is beyond the last corner is never looked at.
    [[nodiscard]] std::size_t length() const { return _stride - kLanes; }
    [[nodiscard]] std::size_t rows() const { return _rows; }

private:
    std::size_t _stride;
    std::size_t _rows;
    std::vector<float> _numbers;
};

/// One octave over a block of a grid whose steps are no longer than a cell.
template <NoiseKind kKind>
class CoherentOctave {
public:
    CoherentOctave(
        const SpaceOctave& octave, const std::vector<double>& x, const std::vector<double>& y)
        : _octave(octave), _plan(placesOf(x, octave.frequency[0], octave.offset[0])),
          _y(placesOf(y, octave.frequency[1], octave.offset[1])),
          _low(_plan.corners(), cornersOver(_y)), _high(_low), _mixed(_low),
          _constants(roomFor(_plan.corners())), _slopes(roomFor(_plan.corners()))
    {
    }

    /// Goes to a slice of the grid.
    void startSlice(double z)
    {
        const Place place = placeOf(z, _octave.frequency[2], _octave.offset[2]);
        if (!_filled || place.index != _index) {
            if (_filled && place.index == _index + 1)
                std::swap(_low, _high);
            else
                fill(_low, place.index);
            fill(_high, place.index + 1);
            _index = place.index;
            _filled = true;
        }
        const Floats centred = constant(place.centred);
        const Floats faded = fade(centred);
        for (std::size_t j = 0; j < _mixed.rows(); ++j) {
            const auto low = _low.row(j);
            const auto high = _high.row(j);
            const auto to = _mixed.row(j);
            for (std::size_t at = 0; at < _mixed.length(); at += kLanes)
                Corners::mixOverZ(low.of, high.of, centred, faded, to.of, at);
        }
    }

    /// The noise of a row's samples, until the next row begins.
    struct Row {
        const CoherentOctave& octave;

        [[nodiscard]] HWY_INLINE Value noise(std::size_t group) const
        {
            return {octave._plan.template noise<Corners::kSloped>(
                group, octave._constants.data(), octave._slopes.data())};
        }
    };

    /// Goes to a row of the slice.
    HWY_INLINE Row startRow(std::size_t row)
    {
        const Floats centred = constant(_y[row].centred);
        const Floats faded = fade(centred);
        const std::size_t j = _y[row].index - _y.front().index;
        const auto low = _mixed.row(j);
        const auto high = _mixed.row(j + 1);
        for (std::size_t at = 0; at < _mixed.length(); at += kLanes)
            Corners::mixOverY(
                low.of, high.of, centred, faded, _constants.data(), _slopes.data(), at);
        return {*this};
    }

private:
    using Corners = CornerNumbers<kKind>;

    void fill(CornerPlane<Corners::kCount>& plane, std::uint32_t z)
    {
        const WordTag w;
        const Words hashZ = hashedZ(hn::Set(w, z), _octave.seed);
        for (std::size_t j = 0; j < plane.rows(); ++j) {
            const auto y = static_cast<std::uint32_t>(_y.front().index + j);
            const Words hashYz = hn::Xor(hashedY(hn::Set(w, y), _octave.seed), hashZ);
            const auto to = plane.row(j);
            for (std::size_t at = 0; at < plane.length(); at += kLanes) {
                const auto x = static_cast<std::uint32_t>(_plan.first() + at);
                const Words hashX = hashedX(hn::Iota(w, x), _octave.seed);
                Corners::store(hn::Xor(hashX, hashYz), to.of, at);
            }
        }
    }

    SpaceOctave _octave;
    RowPlan _plan;
    std::vector<Place> _y;
    CornerPlane<Corners::kCount> _low;  ///< the lattice plane below the slice
    CornerPlane<Corners::kCount> _high; ///< and above
    CornerPlane<Corners::kCount> _mixed;
    std::vector<float> _constants; ///< H, of the row
    std::vector<float> _slopes;    ///< G
    std::uint32_t _index = 0;      ///< of the lattice plane below
    bool _filled = false;
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
