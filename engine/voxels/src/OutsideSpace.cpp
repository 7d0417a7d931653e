#include "OutsideSpace.h"

#include <algorithm>

namespace isofront::voxels {

namespace {

constexpr std::uint32_t kLayer = kChunkEdge * kChunkEdge;

Face opposite(Face face)
{
    return static_cast<Face>(static_cast<unsigned>(face) ^ 1U);
}

} // namespace

OutsideSpace::OutsideSpace(const std::array<std::uint32_t, 3>& counts, const ScratchFile& scratch)
    : _counts(counts), _scratch(scratch)
{
}

core::Result<std::vector<EmptySpace::LayerRun>>
OutsideSpace::layer(std::size_t index, Face face) const
{
    if (_chunkAt[index] == kNone)
        return std::vector<EmptySpace::LayerRun>{{kLayer, 0}};
    const ScratchChunk& chunk = (*_chunks)[_chunkAt[index]];
    const auto which = static_cast<std::size_t>(face);
    std::vector<EmptySpace::LayerRun> runs(chunk.layerRuns[which]);
    if (auto failed = _scratch.read(chunk.layersAt[which], std::as_writable_bytes(std::span(runs))))
        return tl::unexpected(*failed);
    return runs;
}

std::uint32_t OutsideSpace::root(std::uint32_t part)
{
    while (_parent[part] != part) {
        _parent[part] = _parent[_parent[part]];
        part = _parent[part];
    }
    return part;
}

void OutsideSpace::connect(std::uint32_t a, std::uint32_t b)
{
    const std::uint32_t one = root(a);
    const std::uint32_t two = root(b);
    _parent[std::max(one, two)] = std::min(one, two);
}

void OutsideSpace::connect(
    const std::vector<EmptySpace::LayerRun>& a,
    std::uint32_t firstA,
    const std::vector<EmptySpace::LayerRun>& b,
    std::uint32_t firstB)
{
    std::size_t i = 0;
    std::size_t j = 0;
    std::uint32_t endA = a.front().length;
    std::uint32_t endB = b.front().length;
    for (;;) {
        if (a[i].label != kFull && b[j].label != kFull)
            connect(firstA + a[i].label, firstB + b[j].label);
        const bool stepA = endA <= endB;
        const bool stepB = endB <= endA;
        if (stepA && ++i < a.size())
            endA += a[i].length;
        if (stepB && ++j < b.size())
            endB += b[j].length;
        if (i == a.size() || j == b.size())
            return;
    }
}

std::optional<core::Error> OutsideSpace::build(const std::vector<ScratchChunk>& chunks)
{
    const std::size_t count = std::size_t{_counts[0]} * _counts[1] * _counts[2];
    _chunks = &chunks;
    _chunkAt.assign(count, kNone);
    for (std::size_t i = 0; i < chunks.size(); ++i)
        _chunkAt[indexOf(chunks[i].place)] = static_cast<std::uint32_t>(i);
    _first.resize(count);
    std::uint32_t parts = 1;
    for (std::size_t index = 0; index < count; ++index) {
        _first[index] = parts;
        parts += _chunkAt[index] == kNone ? 1 : chunks[_chunkAt[index]].parts;
    }
    _parent.resize(parts);
    for (std::uint32_t part = 0; part < parts; ++part)
        _parent[part] = part;

    const std::vector<EmptySpace::LayerRun> around{{kLayer, 0}};
    std::array<std::uint32_t, 3> place{};
    for (place[2] = 0; place[2] < _counts[2]; ++place[2])
        for (place[1] = 0; place[1] < _counts[1]; ++place[1])
            for (place[0] = 0; place[0] < _counts[0]; ++place[0])
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    const std::size_t index = indexOf(place);
                    const auto low = static_cast<Face>(2 * axis);
                    if (place[axis] == 0) {
                        const auto own = layer(index, low);
                        if (!own)
                            return own.error();
                        connect(around, 0, *own, _first[index]);
                    }
                    const auto own = layer(index, opposite(low));
                    if (!own)
                        return own.error();
                    if (place[axis] + 1 == _counts[axis]) {
                        connect(around, 0, *own, _first[index]);
                        continue;
                    }
                    std::array<std::uint32_t, 3> next = place;
                    ++next[axis];
                    const auto other = layer(indexOf(next), low);
                    if (!other)
                        return other.error();
                    connect(*own, _first[index], *other, _first[indexOf(next)]);
                }
    // flat from here on, so that reading doesn't write
    _closed = 0;
    for (std::uint32_t part = 0; part < parts; ++part) {
        _parent[part] = root(part);
        _closed += part != 0 && _parent[part] == part ? 1U : 0U;
    }
    return std::nullopt;
}

bool OutsideSpace::isOutside(const ScratchChunk& chunk, EmptyLabel part) const
{
    return _parent[_first[indexOf(chunk.place)] + part] == 0;
}

core::Result<std::vector<std::uint64_t>>
OutsideSpace::beyond(const ScratchChunk& chunk, Face face) const
{
    const std::size_t axis = static_cast<std::size_t>(face) / 2;
    const bool high = (static_cast<unsigned>(face) & 1U) != 0;
    if (high ? chunk.place[axis] + 1 == _counts[axis] : chunk.place[axis] == 0)
        return std::vector<std::uint64_t>(kLayer / 64, ~std::uint64_t{0});
    std::array<std::uint32_t, 3> next = chunk.place;
    next[axis] += high ? 1U : ~std::uint32_t{0};
    const auto runs = layer(indexOf(next), opposite(face));
    if (!runs)
        return tl::unexpected(runs.error());
    std::vector<std::uint64_t> bits(kLayer / 64);
    std::uint32_t at = 0;
    for (const EmptySpace::LayerRun& run : *runs) {
        if (run.label != kFull && _parent[_first[indexOf(next)] + run.label] == 0)
            for (std::uint32_t i = at; i < at + run.length; ++i)
                bits[i / 64] |= std::uint64_t{1} << i % 64;
        at += run.length;
    }
    return bits;
}

} // namespace isofront::voxels
