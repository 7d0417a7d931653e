#include "TrilinearKernel.h"

#include <cstring>
#include <limits>
#include <type_traits>

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "TrilinearKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::volume::detail::HWY_NAMESPACE {

namespace {

namespace hn = hwy::HWY_NAMESPACE;

// A block of points is worked off step by step: cells, look-ups, interpolation, sums. Each step is
// a loop of its own over arrays, so that look-ups, which wait for memory, overlap each other.

/// Points of a block that are left out together if none of them counts.
constexpr std::size_t kGroup = 16;

using Doubles = hn::CappedTag<double, kGroup>;
using Reals = hn::Vec<Doubles>;
/// As many of other types as doubles fit a register.
using HalfFloats = hn::Rebind<float, Doubles>;
using HalfIntegers = hn::Rebind<std::int32_t, Doubles>;
/// Full registers.
using Integers = hn::CappedTag<std::int32_t, kGroup>;
using Floats = hn::CappedTag<float, kGroup>;
using Whole = hn::Vec<Integers>;

/// Which groups of a block are to be sampled.
using Groups = std::array<bool, kBlock / kGroup>;

template <typename Visit>
HWY_INLINE void forGroups(const Groups& groups, std::size_t lanes, const Visit& visit)
{
    for (std::size_t group = 0; group < groups.size(); ++group)
        if (groups[group])
            for (std::size_t i = group * kGroup; i < (group + 1) * kGroup; i += lanes)
                visit(i);
}

/// Where points lie along one axis of a grid.
template <typename Number>
struct GridPlaces {
    BlockOf<std::int32_t> cell;
    BlockOf<Number> t; ///< within the cell, 0 at its low and 1 at its high node
};

template <typename Number>
HWY_INLINE void placeInGrid(
    const AxisCells& axis,
    const BlockOf<double>& coordinates,
    const Groups& groups,
    GridPlaces<Number>& out)
{
    const Doubles d;
    const HalfIntegers whole;
    const Reals zero = hn::Zero(d);
    const Reals limit = hn::Set(d, axis.limit);
    const Reals scale = hn::Set(d, axis.scale);
    const Reals lastRatio = hn::Set(d, axis.lastRatio);
    const Reals lastCell = hn::Set(d, static_cast<double>(axis.lastCell));
    const auto lastWhole = hn::Set(whole, axis.lastCell);
    forGroups(groups, hn::Lanes(d), [&](std::size_t i) HWY_ATTR {
        const Reals given = hn::LoadU(d, &coordinates[i]);
        const Reals below = hn::IfThenElse(hn::Lt(given, limit), given, limit);
        const Reals inside = hn::IfThenElse(hn::Gt(given, zero), below, zero); // NaN is not above
        const Reals position = hn::Mul(inside, scale);
        const auto cell = hn::Min(hn::DemoteTo(whole, position), lastWhole);
        const Reals low = hn::PromoteTo(d, cell);
        const Reals rest = hn::Sub(position, low);
        const Reals t = hn::IfThenElse(hn::Eq(low, lastCell), hn::Mul(rest, lastRatio), rest);
        hn::StoreU(cell, whole, &out.cell[i]);
        if constexpr (std::is_same_v<Number, float>)
            hn::StoreU(hn::DemoteTo(HalfFloats(), t), HalfFloats(), &out.t[i]);
        else
            hn::StoreU(t, d, &out.t[i]);
    });
}

// Each kind of nodes says how two of them, side by side along x, are looked up: one pair after the
// other, or, where `kLooksAhead`, four points at a time without asking whether there is a node to
// the right, above or behind; how what was found is kept; and what numbers it holds.

using Cells = BlockOf<std::int32_t>;

template <typename Word>
HWY_INLINE Word wordAt(const char* bytes)
{
    Word word;
    std::memcpy(&word, bytes, sizeof(word));
    return word;
}

/// Four words, each from its place. Written so that they are put together in a register: stores of
/// single words would make the loads of whole registers wait that soon follow, and gathers take
/// twice as long as this (Zen 4), or more.
template <typename Word>
HWY_INLINE void storeFour(const char* base, const std::int32_t* offsets, Word* out)
{
    using Four [[gnu::vector_size(16)]] = Word;
    const Four four = {
        wordAt<Word>(base + static_cast<std::uint32_t>(offsets[0])),
        wordAt<Word>(base + static_cast<std::uint32_t>(offsets[1])),
        wordAt<Word>(base + static_cast<std::uint32_t>(offsets[2])),
        wordAt<Word>(base + static_cast<std::uint32_t>(offsets[3]))};
    std::memcpy(out, &four, sizeof(four));
}

/// Numbers of at most 16 bits: a pair is one word, the left node in its low bits.
template <typename T>
struct SmallNodes {
    static constexpr bool kIsGuarded = false;
    static constexpr bool kIsCoded = false;
    static constexpr bool kLooksAhead = true;
    /// How many bytes are read for a pair.
    static constexpr std::int64_t kReadBytes = 4;
    static constexpr int kBits = 8 * sizeof(T);
    using Pairs = BlockOf<std::int32_t>;

    static std::int64_t offsetOf(std::int64_t node)
    {
        return node * static_cast<std::int64_t>(sizeof(T));
    }
    static HWY_INLINE Whole offsetsOf(Whole nodes)
    {
        return sizeof(T) == 1 ? nodes : hn::ShiftLeft<1>(nodes);
    }

    static HWY_INLINE void
    lookUpFour(const char* nodes, const Cells& offsets, std::size_t i, Pairs& out)
    {
        storeFour(nodes, &offsets[i], &out[i]);
    }
    static HWY_INLINE void align(Whole /*nodes*/, std::size_t /*i*/, Pairs& /*pairs*/) {}

    static void
    lookUp(const void* nodes, std::int64_t left, std::int64_t right, std::size_t i, Pairs& out)
    {
        using Bits = std::make_unsigned_t<T>;
        const T* const all = static_cast<const T*>(nodes);
        const auto low = static_cast<std::uint32_t>(static_cast<Bits>(all[left]));
        const auto high = static_cast<std::uint32_t>(static_cast<Bits>(all[right]));
        out[i] = static_cast<std::int32_t>(low | high << static_cast<unsigned>(kBits));
    }

    template <typename Tag>
    static HWY_INLINE hn::Vec<Tag> left(Tag, const Pairs& pairs, std::size_t i)
    {
        const hn::Rebind<std::int32_t, Tag> d;
        const auto pair = hn::LoadU(d, &pairs[i]);
        if constexpr (std::is_signed_v<T>) // shifted up and down again to extend the sign
            return numbers(Tag(), hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - kBits>(pair)));
        else
            return numbers(Tag(), hn::And(pair, hn::Set(d, (1 << kBits) - 1)));
    }
    template <typename Tag>
    static HWY_INLINE hn::Vec<Tag> right(Tag, const Pairs& pairs, std::size_t i)
    {
        const hn::Rebind<std::int32_t, Tag> d;
        const auto pair = hn::LoadU(d, &pairs[i]);
        if constexpr (std::is_signed_v<T>)
            return numbers(Tag(), hn::ShiftRight<32 - kBits>(hn::ShiftLeft<32 - 2 * kBits>(pair)));
        else
            return numbers(
                Tag(), hn::And(hn::ShiftRight<kBits>(pair), hn::Set(d, (1 << kBits) - 1)));
    }

    template <typename Tag, typename V>
    static HWY_INLINE hn::Vec<Tag> numbers(Tag d, V integers)
    {
        if constexpr (std::is_same_v<hn::TFromD<Tag>, float>)
            return hn::ConvertTo(d, integers);
        else
            return hn::PromoteTo(d, integers);
    }
};

struct Codes16 : SmallNodes<std::uint16_t> {
    static constexpr bool kIsCoded = true;
};

/// A pair is found in one word, from its lowest or from its fifth bit on, and kept as one of 16
/// bits.
struct Codes12 : SmallNodes<std::uint16_t> {
    static constexpr bool kIsCoded = true;
    static constexpr std::int64_t kReadBytes = 3; // and the byte at the end

    static std::int64_t offsetOf(std::int64_t node) { return 3 * node / 2; }
    static HWY_INLINE Whole offsetsOf(Whole nodes)
    {
        return hn::Add(nodes, hn::ShiftRight<1>(nodes));
    }

    static HWY_INLINE void align(Whole nodes, std::size_t i, Pairs& pairs)
    {
        const Integers d;
        const Whole word = hn::LoadU(d, &pairs[i]);
        const auto isOdd = hn::Ne(hn::And(nodes, hn::Set(d, 1)), hn::Zero(d));
        const Whole pair = hn::IfThenElse(isOdd, hn::ShiftRight<4>(word), word);
        const Whole low = hn::And(pair, hn::Set(d, 0xFFF));
        const Whole high = hn::And(hn::ShiftLeft<4>(pair), hn::Set(d, 0xFFF0000));
        hn::StoreU(hn::Or(low, high), d, &pairs[i]);
    }

    static void
    lookUp(const void* nodes, std::int64_t left, std::int64_t right, std::size_t i, Pairs& out)
    {
        out[i] = at(nodes, left) | at(nodes, right) << 16;
    }

private:
    static int at(const void* nodes, std::int64_t i)
    {
        const auto* const b = static_cast<const std::uint8_t*>(nodes) + offsetOf(i);
        const int both = b[0] | b[1] << 8;
        return i % 2 == 0 ? both & 0xFFF : both >> 4;
    }
};

/// Others, of which pairs stay as the numbers they are worked with.
template <typename T>
struct WideNodes {
    static constexpr bool kIsGuarded = std::is_floating_point_v<T>;
    static constexpr bool kIsCoded = false;
    static constexpr bool kLooksAhead = std::is_same_v<T, float>;
    static constexpr std::int64_t kReadBytes = 2 * sizeof(T);
    using Kept = std::conditional_t<std::is_same_v<T, float>, float, double>;
    using Pairs = std::array<BlockOf<Kept>, 2>;

    static std::int64_t offsetOf(std::int64_t node)
    {
        return node * static_cast<std::int64_t>(sizeof(T));
    }
    static HWY_INLINE Whole offsetsOf(Whole nodes) { return hn::ShiftLeft<2>(nodes); }

    static HWY_INLINE void
    lookUpFour(const char* nodes, const Cells& offsets, std::size_t i, Pairs& out)
    {
        storeFour(nodes, &offsets[i], &out[0][i]);
        storeFour(nodes + sizeof(float), &offsets[i], &out[1][i]);
    }
    static HWY_INLINE void align(Whole /*nodes*/, std::size_t /*i*/, Pairs& /*pairs*/) {}

    static void
    lookUp(const void* nodes, std::int64_t left, std::int64_t right, std::size_t i, Pairs& out)
    {
        const T* const all = static_cast<const T*>(nodes);
        out[0][i] = static_cast<Kept>(all[left]);
        out[1][i] = static_cast<Kept>(all[right]);
    }

    static HWY_INLINE Reals left(Doubles, const Pairs& pairs, std::size_t i)
    {
        return numbers(&pairs[0][i]);
    }
    static HWY_INLINE Reals right(Doubles, const Pairs& pairs, std::size_t i)
    {
        return numbers(&pairs[1][i]);
    }

    static HWY_INLINE Reals numbers(const Kept* kept)
    {
        if constexpr (std::is_same_v<T, float>)
            return hn::PromoteTo(Doubles(), hn::LoadU(HalfFloats(), kept));
        else
            return hn::LoadU(Doubles(), kept);
    }
};

template <bool kIsGuarded, typename Tag, typename V>
HWY_INLINE V between(Tag d, V a, V b, V t)
{
    const V mixed = hn::Add(a, hn::Mul(t, hn::Sub(b, a)));
    if constexpr (kIsGuarded)
        return hn::IfThenElse(hn::Eq(t, hn::Zero(d)), a, mixed);
    else
        return mixed;
}

/// Along x, then y, then z.
/// @param nodeAt  gives the node at a corner, by 4 z + 2 y + x
template <bool kIsGuarded, typename Tag, typename NodeAt, typename V>
HWY_INLINE V interpolated(Tag d, const NodeAt& nodeAt, V x, V y, V z)
{
    const auto alongX = [&](std::size_t k) HWY_ATTR {
        return between<kIsGuarded>(d, nodeAt(k), nodeAt(k + 1), x);
    };
    const V low = between<kIsGuarded>(d, alongX(0), alongX(2), y);
    const V high = between<kIsGuarded>(d, alongX(4), alongX(6), y);
    return between<kIsGuarded>(d, low, high, z);
}

/// Samples one grid at one block of points.
template <typename Nodes, typename Number>
class Sampler {
public:
    using Places = GridPlaces<Number>;

    Sampler(const NodeGrid& grid, const Groups& groups)
        : _grid(grid), _groups(groups), _stepY(grid.size.y > 1 ? grid.row : 0),
          _stepZ(grid.size.z > 1 ? grid.slice : 0)
    {
    }

    HWY_INLINE void place(std::size_t axis, const BlockOf<double>& coordinates, Places& out) const
    {
        placeInGrid(_grid.axes[axis], coordinates, _groups, out);
    }

    HWY_INLINE void
    sample(const Places& x, const Places& y, const Places& z, BlockOf<Number>& out) const
    {
        Rows rows;
        if (!lookUpAhead(x.cell, y.cell, z.cell, rows))
            lookUpEach(x.cell, y.cell, z.cell, rows);
        const hn::CappedTag<Number, kGroup> d;
        forGroups(_groups, hn::Lanes(d), [&](std::size_t i) HWY_ATTR {
            const auto nodeAt = [&](std::size_t k) HWY_ATTR {
                const auto& row = rows[k / 2];
                return k % 2 == 0 ? Nodes::left(d, row, i) : Nodes::right(d, row, i);
            };
            const auto value = interpolated<Nodes::kIsGuarded>(
                d, nodeAt, hn::LoadU(d, &x.t[i]), hn::LoadU(d, &y.t[i]), hn::LoadU(d, &z.t[i]));
            hn::StoreU(value, d, &out[i]);
        });
    }

private:
    /// The pairs of nodes at the four edges of cells along x, by 2 z + y.
    using Rows = std::array<typename Nodes::Pairs, 4>;

    /// Looks up pairs without a thought for the last nodes of rows, of slices and of the grid. What
    /// is found instead of nodes that are not there has the weight zero.
    /// @return false, and nothing that counts, if that would leave the grid
    HWY_INLINE bool lookUpAhead(const Cells& x, const Cells& y, const Cells& z, Rows& rows) const
    {
        if constexpr (!Nodes::kLooksAhead) {
            return false;
        } else {
            // where the last pair may lie from which others are reached [bytes], in 32 bits
            const std::int64_t end = Nodes::offsetOf(_grid.count());
            const std::int64_t last = end - Nodes::kReadBytes - Nodes::offsetOf(_stepY + _stepZ);
            if (last < 0 || end > std::numeric_limits<std::int32_t>::max())
                return false;
            const Integers d;
            const Whole row = hn::Set(d, static_cast<std::int32_t>(_grid.row));
            const Whole slice = hn::Set(d, static_cast<std::int32_t>(_grid.slice));
            Cells nodes;
            Cells offsets;
            Whole most = hn::Zero(d);
            forGroups(_groups, hn::Lanes(d), [&](std::size_t i) HWY_ATTR {
                const Whole inSlice =
                    hn::Add(hn::Mul(hn::LoadU(d, &y[i]), row), hn::LoadU(d, &x[i]));
                const Whole node = hn::Add(hn::Mul(hn::LoadU(d, &z[i]), slice), inSlice);
                const Whole offset = Nodes::offsetsOf(node);
                most = hn::Max(most, offset);
                hn::StoreU(node, d, &nodes[i]);
                hn::StoreU(offset, d, &offsets[i]);
            });
            const Whole lastOffset = hn::Set(d, static_cast<std::int32_t>(last));
            if (!hn::AllFalse(d, hn::Gt(most, lastOffset)))
                return false;
            const char* const first = static_cast<const char*>(_grid.nodes);
            const std::array<const char*, 4> starts = {
                first,
                first + Nodes::offsetOf(_stepY),
                first + Nodes::offsetOf(_stepZ),
                first + Nodes::offsetOf(_stepY + _stepZ)};
            forGroups(_groups, 4, [&](std::size_t i) HWY_ATTR {
                Nodes::lookUpFour(starts[0], offsets, i, rows[0]);
                Nodes::lookUpFour(starts[1], offsets, i, rows[1]);
                Nodes::lookUpFour(starts[2], offsets, i, rows[2]);
                Nodes::lookUpFour(starts[3], offsets, i, rows[3]);
            });
            for (std::size_t k = 0; k < 4; ++k)
                forGroups(_groups, hn::Lanes(d), [&](std::size_t i) HWY_ATTR {
                    Nodes::align(hn::LoadU(d, &nodes[i]), i, rows[k]);
                });
            return true;
        }
    }

    HWY_NOINLINE void lookUpEach(const Cells& x, const Cells& y, const Cells& z, Rows& rows) const
    {
        forGroups(_groups, 1, [&](std::size_t i) {
            const std::int64_t near = z[i] * _grid.slice + y[i] * _grid.row + x[i];
            const std::int64_t stepX = x[i] < _grid.size.x - 1 ? 1 : 0;
            const std::int64_t stepY = y[i] < _grid.size.y - 1 ? _grid.row : 0;
            const std::int64_t stepZ = z[i] < _grid.size.z - 1 ? _grid.slice : 0;
            for (std::size_t k = 0; k < 4; ++k) {
                const std::int64_t left =
                    near + ((k & 1U) != 0 ? stepY : 0) + ((k & 2U) != 0 ? stepZ : 0);
                Nodes::lookUp(_grid.nodes, left, left + stepX, i, rows[k]);
            }
        });
    }

    const NodeGrid& _grid;
    const Groups& _groups;
    std::int64_t _stepY; ///< from row to row where there are several [nodes]
    std::int64_t _stepZ; ///< from slice to slice
};

/// Calls take(place, values) for each probe that is wanted.
template <typename Nodes, typename Number, typename Take>
HWY_INLINE void forProbes(
    const NodeGrid& grid,
    const Block& points,
    const Probes& probes,
    const Groups& groups,
    const Take& take)
{
    const Sampler<Nodes, Number> sampler(grid, groups);
    std::array<GridPlaces<Number>, 3> places;
    for (std::size_t axis = 0; axis < 3; ++axis)
        sampler.place(axis, points.coordinate[axis], places[axis]);
    BlockOf<Number> values;
    if (probes.centre) {
        sampler.sample(places[0], places[1], places[2], values);
        take(0, values);
    }
    if (!probes.around)
        return;
    for (std::size_t k = 0; k < 6; ++k) {
        const std::size_t axis = k / 2;
        BlockOf<double> moved;
        for (std::size_t i = 0; i < kBlock; ++i)
            moved[i] = points.coordinate[axis][i] + (k % 2 == 0 ? points.step[i] : -points.step[i]);
        GridPlaces<Number> place;
        sampler.place(axis, moved, place);
        sampler.sample(
            axis == 0 ? place : places[0],
            axis == 1 ? place : places[1],
            axis == 2 ? place : places[2],
            values);
        take(k + 1, values);
    }
}

template <typename Nodes>
void probeNodes(const NodeGrid& grid, const Block& points, const Probes& probes, Probed& values)
{
    Groups groups;
    for (std::size_t group = 0; group < groups.size(); ++group)
        groups[group] = group * kGroup < points.size;
    forProbes<Nodes, double>(
        grid, points, probes, groups, [&](std::size_t k, const BlockOf<double>& found) {
            values[k] = found;
        });
}

template <typename Nodes>
void addNodes(
    const NodeGrid& grid,
    const Block& points,
    const Probes& probes,
    const BlockOf<double>& weights,
    Probed& values)
{
    const Doubles d;
    Groups groups{};
    for (std::size_t i = 0; i < points.size; i += hn::Lanes(d))
        if (!hn::AllFalse(d, hn::Gt(hn::LoadU(d, &weights[i]), hn::Zero(d))))
            groups[i / kGroup] = true;
    using Number = std::conditional_t<Nodes::kIsCoded, float, double>;
    const Reals low = hn::Set(d, grid.low);
    const Reals step = hn::Set(d, grid.step);
    forProbes<Nodes, Number>(
        grid, points, probes, groups, [&](std::size_t k, const BlockOf<Number>& found) HWY_ATTR {
            forGroups(groups, hn::Lanes(d), [&](std::size_t i) HWY_ATTR {
                Reals value;
                if constexpr (Nodes::kIsCoded) {
                    const Reals code = hn::PromoteTo(d, hn::LoadU(HalfFloats(), &found[i]));
                    value = hn::Add(low, hn::Mul(step, code));
                } else {
                    value = hn::LoadU(d, &found[i]);
                }
                const Reals weight = hn::LoadU(d, &weights[i]);
                const Reals before = hn::LoadU(d, &values[k][i]);
                const Reals after = hn::Add(before, hn::Mul(weight, value));
                hn::StoreU(
                    hn::IfThenElse(hn::Gt(weight, hn::Zero(d)), after, before), d, &values[k][i]);
            });
        });
}

/// Calls with the kind of nodes that a type has.
template <typename Call>
HWY_INLINE void withNodes(NodeType type, const Call& call)
{
    switch (type) {
    case NodeType::int8:
        return call(SmallNodes<std::int8_t>());
    case NodeType::uint8:
        return call(SmallNodes<std::uint8_t>());
    case NodeType::int16:
        return call(SmallNodes<std::int16_t>());
    case NodeType::uint16:
        return call(SmallNodes<std::uint16_t>());
    case NodeType::int32:
        return call(WideNodes<std::int32_t>());
    case NodeType::uint32:
        return call(WideNodes<std::uint32_t>());
    case NodeType::float32:
        return call(WideNodes<float>());
    case NodeType::float64:
        return call(WideNodes<double>());
    case NodeType::codes12:
        return call(Codes12());
    case NodeType::codes16:
        return call(Codes16());
    }
}

template <bool kIsGuarded>
void interpolateCellsOf(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    BlockOf<double>& out)
{
    const Doubles d;
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const auto nodeAt = [&](std::size_t k) HWY_ATTR { return hn::LoadU(d, &corners[k][i]); };
        const Reals value = interpolated<kIsGuarded>(
            d, nodeAt, hn::LoadU(d, &x.t[i]), hn::LoadU(d, &y.t[i]), hn::LoadU(d, &z.t[i]));
        hn::StoreU(value, d, &out[i]);
    }
}

} // namespace

void placeInCellsOn(
    const BlockOf<double>& coordinates,
    std::size_t count,
    double low,
    double high,
    double scale,
    CellPlaces& out)
{
    const Doubles d;
    const HalfIntegers whole;
    const Reals least = hn::Set(d, low);
    const Reals most = hn::Set(d, high);
    for (std::size_t i = 0; i < count; i += hn::Lanes(d)) {
        const Reals given = hn::LoadU(d, &coordinates[i]);
        const Reals below = hn::IfThenElse(hn::Lt(given, most), given, most);
        const Reals inside = hn::IfThenElse(hn::Gt(given, least), below, least); // NaN is not above
        const Reals position = hn::Mul(hn::Set(d, scale), inside);
        // truncated towards zero, and then floored
        const Reals truncated = hn::PromoteTo(d, hn::DemoteTo(whole, position));
        const Reals one = hn::Set(d, 1.0);
        const Reals cell =
            hn::IfThenElse(hn::Gt(truncated, position), hn::Sub(truncated, one), truncated);
        hn::StoreU(hn::DemoteTo(whole, cell), whole, &out.cell[i]);
        hn::StoreU(hn::Sub(position, cell), d, &out.t[i]);
    }
}

void interpolateCellsOn(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool isGuarded,
    BlockOf<double>& out)
{
    if (isGuarded)
        interpolateCellsOf<true>(corners, x, y, z, count, out);
    else
        interpolateCellsOf<false>(corners, x, y, z, count, out);
}

void probeOn(const NodeGrid& grid, const Block& points, const Probes& probes, Probed& values)
{
    withNodes(
        grid.type, [&](auto nodes) { probeNodes<decltype(nodes)>(grid, points, probes, values); });
}

void addProbedOn(
    const NodeGrid& grid,
    const Block& points,
    const Probes& probes,
    const BlockOf<double>& weights,
    Probed& values)
{
    withNodes(grid.type, [&](auto nodes) {
        addNodes<decltype(nodes)>(grid, points, probes, weights, values);
    });
}

} // namespace isofront::volume::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::volume::detail {

HWY_EXPORT(placeInCellsOn);
HWY_EXPORT(interpolateCellsOn);
HWY_EXPORT(probeOn);
HWY_EXPORT(addProbedOn);

void placeInCells(
    const BlockOf<double>& coordinates,
    std::size_t count,
    double low,
    double high,
    double scale,
    CellPlaces& out)
{
    HWY_DYNAMIC_DISPATCH(placeInCellsOn)(coordinates, count, low, high, scale, out);
}

void interpolateCells(
    const CellCorners& corners,
    const CellPlaces& x,
    const CellPlaces& y,
    const CellPlaces& z,
    std::size_t count,
    bool isGuarded,
    BlockOf<double>& out)
{
    HWY_DYNAMIC_DISPATCH(interpolateCellsOn)(corners, x, y, z, count, isGuarded, out);
}

void probe(const NodeGrid& grid, const Block& points, const Probes& probes, Probed& values)
{
    HWY_DYNAMIC_DISPATCH(probeOn)(grid, points, probes, values);
}

void addProbed(
    const NodeGrid& grid,
    const Block& points,
    const Probes& probes,
    const BlockOf<double>& weights,
    Probed& values)
{
    HWY_DYNAMIC_DISPATCH(addProbedOn)(grid, points, probes, weights, values);
}

} // namespace isofront::volume::detail
#endif
