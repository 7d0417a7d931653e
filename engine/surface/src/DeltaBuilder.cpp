#include "DeltaBuilder.h"

#include <isofront/core/Assert.h>
#include <isofront/hierarchy/Diamond.h>

#include <algorithm>
#include <tuple>
#include <utility>

namespace isofront::surface {

void DeltaBuilder::begin(const hierarchy::LatticePoint& diamond)
{
    _steps.push_back({diamond, hierarchy::Diamond(diamond).level, _steps.size()});
}

void DeltaBuilder::remove(const CellId& id, const CellMeshPointer& mesh)
{
    ISOFRONT_ASSERT(!_steps.empty(), "cells change by steps");
    const std::size_t step = _steps.size() - 1;
    if (const auto found = _added.find(id); found != _added.end()) {
        join(found->second.step, step);
        _added.erase(found);
        return;
    }
    _removed[id] = {mesh, step};
}

void DeltaBuilder::add(const CellId& id, CellMeshPointer mesh)
{
    ISOFRONT_ASSERT(!_steps.empty(), "cells change by steps");
    const std::size_t step = _steps.size() - 1;
    if (const auto found = _removed.find(id); found != _removed.end()) {
        join(found->second.step, step);
        if (found->second.mesh == mesh) {
            _removed.erase(found);
            return;
        }
    }
    _added[id] = {std::move(mesh), step};
}

Delta DeltaBuilder::build(std::uint64_t version, double isovalue)
{
    struct Line {
        hierarchy::LatticePoint diamond;
        CellId id;
        CellMeshPointer mesh;
    };
    const auto linesOf = [&](auto& entries) {
        std::vector<Line> lines;
        for (auto& [id, entry] : entries)
            if (entry.mesh)
                lines.push_back({_steps[rootOf(entry.step)].diamond, id, std::move(entry.mesh)});
        std::ranges::sort(
            lines, {}, [](const Line& line) { return std::tie(line.diamond, line.id); });
        entries.clear();
        return lines;
    };
    const std::vector<Line> removed = linesOf(_removed);
    std::vector<Line> added = linesOf(_added);

    Delta delta;
    delta.version = version;
    delta.isovalue = isovalue;
    delta.removed.reserve(removed.size());
    delta.added.reserve(added.size());
    auto gone = removed.begin();
    auto come = added.begin();
    while (gone != removed.end() || come != added.end()) {
        DeltaStep step;
        step.diamond =
            come == added.end() || (gone != removed.end() && gone->diamond < come->diamond)
                ? gone->diamond
                : come->diamond;
        for (; gone != removed.end() && gone->diamond == step.diamond; ++gone, ++step.removed)
            delta.removed.push_back(gone->id);
        for (; come != added.end() && come->diamond == step.diamond; ++come, ++step.added)
            delta.added.emplace_back(come->id, std::move(come->mesh));
        delta.steps.push_back(step);
    }
    _steps.clear();
    return delta;
}

std::size_t DeltaBuilder::rootOf(std::size_t step)
{
    while (_steps[step].parent != step) {
        _steps[step].parent = _steps[_steps[step].parent].parent;
        step = _steps[step].parent;
    }
    return step;
}

void DeltaBuilder::join(std::size_t a, std::size_t b)
{
    a = rootOf(a);
    b = rootOf(b);
    if (a == b)
        return;
    const auto rank = [this](std::size_t step) {
        return std::tie(_steps[step].level, _steps[step].diamond);
    };
    if (rank(b) < rank(a))
        std::swap(a, b);
    _steps[b].parent = a;
}

} // namespace isofront::surface
