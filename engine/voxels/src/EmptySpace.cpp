#include "EmptySpace.h"

#include <algorithm>

namespace isofront::voxels {

namespace {

constexpr std::size_t kRows = std::size_t{kChunkEdge} * kChunkEdge;

} // namespace

EmptySpace::EmptySpace() : _rowBegin(kRows + 1) {}

EmptyLabel EmptySpace::root(EmptyLabel label)
{
    while (_parent[label] != label) {
        _parent[label] = _parent[_parent[label]];
        label = _parent[label];
    }
    return label;
}

void EmptySpace::connect(std::size_t rowA, std::size_t rowB)
{
    std::uint32_t a = _rowBegin[rowA];
    std::uint32_t b = _rowBegin[rowB];
    while (a < _rowBegin[rowA + 1] && b < _rowBegin[rowB + 1]) {
        if (_runs[a].begin < _runs[b].end && _runs[b].begin < _runs[a].end) {
            const EmptyLabel one = root(a);
            const EmptyLabel two = root(b);
            // to the one that came first, so that labels follow the order of rows
            _parent[std::max(one, two)] = std::min(one, two);
        }
        if (_runs[a].end < _runs[b].end)
            ++a;
        else
            ++b;
    }
}

void EmptySpace::build(std::span<const WeightedVoxel> voxels)
{
    _runs.clear();
    auto voxel = voxels.begin();
    for (std::size_t index = 0; index < kRows; ++index) {
        _rowBegin[index] = static_cast<std::uint32_t>(_runs.size());
        std::uint32_t begin = 0;
        for (; voxel != voxels.end() && voxel->order() / kChunkEdge == index; ++voxel) {
            const std::uint32_t x = voxel->order() % kChunkEdge;
            if (x > begin)
                _runs.push_back(
                    {static_cast<std::uint16_t>(begin), static_cast<std::uint16_t>(x), 0});
            begin = x + 1;
        }
        if (begin < kChunkEdge)
            _runs.push_back({static_cast<std::uint16_t>(begin), kChunkEdge, 0});
    }
    _rowBegin[kRows] = static_cast<std::uint32_t>(_runs.size());

    _parent.resize(_runs.size());
    for (std::size_t i = 0; i < _parent.size(); ++i)
        _parent[i] = static_cast<EmptyLabel>(i);
    for (std::size_t index = 0; index < kRows; ++index) {
        if (index % kChunkEdge != 0)
            connect(index - 1, index);
        if (index >= kChunkEdge)
            connect(index - kChunkEdge, index);
    }
    // a root comes before all others of its part
    _parts = 0;
    for (std::size_t i = 0; i < _runs.size(); ++i) {
        const EmptyLabel first = root(static_cast<EmptyLabel>(i));
        _runs[i].label = first == i ? _parts++ : _runs[first].label;
    }
}

EmptyLabel EmptySpace::at(std::uint32_t x, std::uint32_t y, std::uint32_t z) const
{
    const std::span<const Run> runs = row(y, z);
    const auto run = std::ranges::upper_bound(runs, x, {}, &Run::begin);
    return run != runs.begin() && x < (run - 1)->end ? (run - 1)->label : kFull;
}

std::vector<EmptySpace::LayerRun> EmptySpace::layer(Face face) const
{
    std::vector<LayerRun> layer;
    const auto add = [&](std::uint32_t length, EmptyLabel label) {
        if (!layer.empty() && layer.back().label == label)
            layer.back().length += length;
        else if (length > 0)
            layer.push_back({length, label});
    };
    const auto addRow = [&](std::uint32_t y, std::uint32_t z) {
        std::uint32_t x = 0;
        for (const Run& run : row(y, z)) {
            add(run.begin - x, kFull);
            add(static_cast<std::uint32_t>(run.end - run.begin), run.label);
            x = run.end;
        }
        add(kChunkEdge - x, kFull);
    };
    const bool high = (static_cast<unsigned>(face) & 1U) != 0;
    const std::uint32_t place = high ? kChunkEdge - 1 : 0;
    for (std::uint32_t i = 0; i < kChunkEdge; ++i) {
        switch (static_cast<unsigned>(face) / 2) {
        case 0:
            for (std::uint32_t y = 0; y < kChunkEdge; ++y) {
                const std::span<const Run> runs = row(y, i);
                const Run* run = runs.empty() ? nullptr : high ? &runs.back() : runs.data();
                const bool empty = run != nullptr && run->begin <= place && place < run->end;
                add(1, empty ? run->label : kFull);
            }
            break;
        case 1:
            addRow(place, i);
            break;
        default:
            addRow(i, place);
            break;
        }
    }
    return layer;
}

} // namespace isofront::voxels
