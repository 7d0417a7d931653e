#include "EmptySpace.h"

#include <algorithm>

namespace isofront::voxels {

namespace {

constexpr std::size_t kRows = std::size_t{kChunkEdge} * kChunkEdge;

} // namespace

EmptySpace::EmptySpace() : _rows(kRows) {}

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
    std::uint32_t a = _rows[rowA].begin;
    std::uint32_t b = _rows[rowB].begin;
    while (a < _rows[rowA].end && b < _rows[rowB].end) {
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
        const bool isEmpty = voxel == voxels.end() || voxel->order() / kChunkEdge != index;
        if (isEmpty && index % kChunkEdge != 0 && isWhole(index - 1)) {
            _rows[index] = _rows[index - 1];
            continue;
        }
        _rows[index].begin = static_cast<std::uint32_t>(_runs.size());
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
        _rows[index].end = static_cast<std::uint32_t>(_runs.size());
    }

    _parent.resize(_runs.size());
    for (std::size_t i = 0; i < _parent.size(); ++i)
        _parent[i] = static_cast<EmptyLabel>(i);
    for (std::size_t index = 0; index < kRows; ++index) {
        const bool isShared = index % kChunkEdge != 0 && areShared(index - 1, index);
        if (index % kChunkEdge != 0 && !isShared)
            connect(index - 1, index);
        // where both rows are those before them, so is what connects them
        if (index >= kChunkEdge &&
            !(isShared && areShared(index - 1 - kChunkEdge, index - kChunkEdge)))
            connect(index - kChunkEdge, index);
    }
    // a root comes before all others of its part
    _parts = 0;
    for (std::size_t i = 0; i < _runs.size(); ++i) {
        const EmptyLabel first = root(static_cast<EmptyLabel>(i));
        _runs[i].label = first == i ? _parts++ : _runs[first].label;
    }
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
