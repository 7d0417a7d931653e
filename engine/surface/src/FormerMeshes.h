#pragma once

#include "CellCache.h"

#include <isofront/hierarchy/CellId.h>

#include <algorithm>
#include <cstddef>
#include <unordered_map>
#include <utility>
#include <vector>

namespace isofront::surface {

using CellMeshes = std::unordered_map<hierarchy::CellId, CellMeshPointer, hierarchy::CellIdHash>;

/// All that is known of the cells of a surface that is not on show any more, or never was: another
/// isovalue's, or one that was given up half way. It goes to the cache piece by piece.
///
/// Thread: one at a time; `find` any number while nobody else calls.
class FormerMeshes {
public:
    struct EmptyCell {
        hierarchy::CellId id;
        bool proved = false; ///< by bounds
    };

    FormerMeshes() = default;
    /// @param meshes  those with triangles
    /// @param empty   cells known to have none, in the order of their names
    /// @param bytes   of the meshes
    FormerMeshes(
        CellMeshes meshes, std::vector<EmptyCell> empty, std::size_t bytes, double isovalue)
        : _meshes(std::move(meshes)), _empty(std::move(empty)), _meshBytes(bytes),
          _isovalue(isovalue)
    {
    }

    [[nodiscard]] double isovalue() const { return _isovalue; }
    /// Memory held, about [bytes].
    [[nodiscard]] std::size_t bytes() const
    {
        return _meshBytes + _empty.size() * sizeof(EmptyCell);
    }
    [[nodiscard]] bool isDone() const { return _meshes.empty() && _empty.empty(); }

    /// The mesh, one without triangles for a cell known to be empty, or null.
    [[nodiscard]] CellMeshPointer find(const hierarchy::CellId& id) const
    {
        if (const auto found = _meshes.find(id); found != _meshes.end())
            return found->second;
        const auto at = std::ranges::lower_bound(_empty, id, {}, &EmptyCell::id);
        return at != _empty.end() && at->id == id ? meshOfEmptyCell(at->proved) : nullptr;
    }

    /// Hands one cell over to the cache; there must be one left.
    void moveOneTo(CellCache& cache)
    {
        if (!_empty.empty()) {
            cache.insert({_empty.back().id, _isovalue}, meshOfEmptyCell(_empty.back().proved));
            _empty.pop_back();
            return;
        }
        auto node = _meshes.extract(_meshes.begin());
        _meshBytes -= node.mapped()->bytes();
        cache.insert({node.key(), _isovalue}, std::move(node.mapped()));
    }

private:
    CellMeshes _meshes;
    std::vector<EmptyCell> _empty;
    std::size_t _meshBytes = 0;
    double _isovalue = 0;
};

} // namespace isofront::surface
