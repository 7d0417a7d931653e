#include "Reduction.h"

#include <isofront/voxels/Chunk.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace isofront::voxels {

namespace {

/// A voxel of a child.
struct ChildVoxel {
    const VoxelList* list = nullptr;
    std::size_t index = 0;

    [[nodiscard]] const WeightedVoxel& voxel() const { return list->voxels[index]; }
    [[nodiscard]] WeightedColour colour() const
    {
        return list->colours.empty() ? WeightedColour{} : list->colours[index];
    }
    /// Null where it has none.
    [[nodiscard]] const WeightedFaces* faces() const
    {
        const auto found = std::ranges::lower_bound(list->faces, index, {}, &WeightedFaces::voxel);
        return found != list->faces.end() && found->voxel == index ? &*found : nullptr;
    }
};

/// Those of one voxel of the parent, in the order of their places.
class Siblings {
public:
    void clear() { _count = 0; }
    void add(const ChildVoxel& child) { _children[_count++] = child; }
    [[nodiscard]] std::span<const ChildVoxel> all() const { return {_children.data(), _count}; }

private:
    std::array<ChildVoxel, 8> _children{};
    std::size_t _count = 0;
};

bool hasNormal(const WeightedVoxel& voxel)
{
    return voxel.normal[0] != 0 || voxel.normal[1] != 0 || voxel.normal[2] != 0;
}

/// What each face of a voxel shows: of the children that show it those that are turned to it, as
/// far as they are; if none is, all alike.
WeightedFaces facesOf(std::span<const ChildVoxel> children)
{
    WeightedFaces turned;
    WeightedFaces all;
    for (const ChildVoxel& which : children) {
        const WeightedVoxel& child = which.voxel();
        const WeightedFaces* own = which.faces();
        for (std::size_t face = 0; face < kFaces; ++face) {
            if ((child.place >> 24U & faceBit(static_cast<Face>(face))) == 0)
                continue;
            if (own != nullptr && own->faces[face].area > 0) {
                addAttributes(turned.faces[face], own->faces[face]);
                continue;
            }
            const WeightedFace seen{child.normal, child.area, which.colour()};
            addAttributes(all.faces[face], seen);
            const float along = seen.normal[face / 2] * (face % 2 != 0 ? 1.0F : -1.0F);
            if (along > 0 && seen.area > 0)
                addAttributes(turned.faces[face], scaled(seen, along / seen.area));
        }
    }
    for (std::size_t face = 0; face < kFaces; ++face)
        if (turned.faces[face].area <= 0)
            turned.faces[face] = all.faces[face];
    return turned;
}

/// Adds the voxel of the parent that some make.
/// @param place  in the parent, without faces
void addParent(std::uint32_t place, std::span<const ChildVoxel> children, VoxelList& parents)
{
    const WeightedVoxel& first = children.front().voxel();
    WeightedVoxel sum = first;
    for (const ChildVoxel& child : children.subspan(1)) {
        sum.place |= child.voxel().place; // only the faces count
        addSurface(sum, child.voxel());
    }
    if (!children.front().list->colours.empty()) {
        WeightedColour colour = children.front().colour();
        for (const ChildVoxel& child : children.subspan(1))
            addColour(colour, child.colour());
        parents.colours.push_back(colour);
    }
    sum.place = place | (sum.place & static_cast<std::uint32_t>(kAllFaces) << 24U);
    if (isMixed(sum)) {
        WeightedFaces faces = facesOf(children);
        faces.voxel = static_cast<std::uint32_t>(parents.voxels.size());
        parents.faces.push_back(faces);
    }
    if (!hasNormal(sum)) // two sides of a sheet: either is better than none
        sum.normal = first.normal;
    parents.voxels.push_back(sum);
}

constexpr std::uint32_t kHalf = kChunkEdge / 2;
constexpr std::uint32_t kNone = 0xffffffffU;

/// A child's voxels in two of its layers that make one of the parent's.
class LayerPair {
public:
    LayerPair() = default;
    /// @param layer  of the parent's half
    LayerPair(const VoxelList& list, std::uint32_t layer) : _list(&list)
    {
        const auto beginOf = [&](std::uint32_t z) {
            return static_cast<std::size_t>(
                std::ranges::lower_bound(list.voxels, z << 16U, {}, &WeightedVoxel::order) -
                list.voxels.begin());
        };
        _at = {beginOf(2 * layer), beginOf(2 * layer + 1)};
        _end = {_at[1], beginOf(2 * layer + 2)};
    }
    /// The parent's row that comes next, in its half; kNone after the last.
    [[nodiscard]] std::uint32_t row() const
    {
        std::uint32_t row = kNone;
        for (std::size_t layer = 0; layer < 2; ++layer)
            if (_at[layer] < _end[layer])
                row = std::min(row, orderAt(_at[layer]) >> 9U & 0x7fU);
        return row;
    }
    /// Adds the parent's voxels of a row, by merging those of four of the child's.
    /// @param place  of the row's first voxel in the parent
    void addRow(std::uint32_t row, std::uint32_t place, VoxelList& parents)
    {
        std::array<std::size_t, 4> at{};
        std::array<std::size_t, 4> end{};
        for (std::size_t layer = 0; layer < 2; ++layer)
            for (std::uint32_t half = 0; half < 2; ++half) {
                const std::size_t which = 2 * layer + half;
                at[which] = _at[layer];
                while (_at[layer] < _end[layer] &&
                       (orderAt(_at[layer]) >> 8U & 0xffU) == 2 * row + half)
                    ++_at[layer];
                end[which] = _at[layer];
            }
        const auto columnAt = [&](std::size_t i) { return orderAt(i) >> 1U & 0x7fU; };
        Siblings siblings;
        while (true) {
            std::uint32_t column = kNone;
            for (std::size_t i = 0; i < at.size(); ++i)
                if (at[i] < end[i])
                    column = std::min(column, columnAt(at[i]));
            if (column == kNone)
                return;
            siblings.clear();
            for (std::size_t i = 0; i < at.size(); ++i)
                for (; at[i] < end[i] && columnAt(at[i]) == column; ++at[i])
                    siblings.add({_list, at[i]});
            addParent(place + column, siblings.all(), parents);
        }
    }

private:
    [[nodiscard]] std::uint32_t orderAt(std::size_t index) const
    {
        return _list->voxels[index].order();
    }

    const VoxelList* _list = nullptr;
    std::array<std::size_t, 2> _at{};
    std::array<std::size_t, 2> _end{};
};

} // namespace

VoxelList reduced(const std::array<const VoxelList*, 8>& children)
{
    VoxelList parents;
    std::size_t count = 0;
    for (const VoxelList* child : children)
        count += child != nullptr ? child->voxels.size() : 0;
    parents.voxels.reserve(count / 3);
    for (std::uint32_t z = 0; z < kChunkEdge; ++z)
        for (std::uint32_t upper = 0; upper < 2; ++upper) {
            // two children side by side along x
            std::array<LayerPair, 2> pair;
            for (std::uint32_t side = 0; side < 2; ++side) {
                const VoxelList* child = children[side | upper << 1U | z / kHalf << 2U];
                if (child != nullptr)
                    pair[side] = LayerPair(*child, z % kHalf);
            }
            while (true) {
                const std::uint32_t row = std::min(pair[0].row(), pair[1].row());
                if (row == kNone)
                    break;
                for (std::uint32_t side = 0; side < 2; ++side)
                    if (pair[side].row() == row)
                        pair[side].addRow(
                            row, packPlace(side * kHalf, upper * kHalf + row, z, 0), parents);
            }
        }
    return parents;
}

} // namespace isofront::voxels
