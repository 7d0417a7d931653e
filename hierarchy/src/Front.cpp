#include "isofront/hierarchy/Front.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <unordered_set>

namespace isofront::hierarchy {

Front::Front()
{
    _nodes[kRootDiamond].present = tetrahedraOf(Diamond(kRootDiamond)).mask();
    _cellCount = 6;
}

bool Front::isSplit(const LatticePoint& diamond) const
{
    const Node* node = _nodes.find(diamond);
    return node != nullptr && node->split;
}

bool Front::isComplete(const LatticePoint& diamond) const
{
    const Node* node = _nodes.find(diamond);
    return node != nullptr && !node->split &&
           node->present == tetrahedraOf(Diamond(diamond)).mask();
}

bool Front::isKnown(const LatticePoint& diamond) const
{
    return _nodes.contains(diamond);
}

bool Front::hasCell(const CellId& id) const
{
    const Node* node = _nodes.find(id.spine);
    return node != nullptr && (unsigned{node->present} >> id.index & 1U) != 0;
}

DiamondState Front::stateOf(const LatticePoint& diamond) const
{
    const Node* node = _nodes.find(diamond);
    if (node == nullptr)
        return {0, false};
    if (node->split)
        return {tetrahedraOf(Diamond(diamond)).mask(), true};
    return {node->present, false};
}

bool Front::isMergeable(const LatticePoint& diamond) const
{
    if (!isSplit(diamond))
        return false;
    for (const LatticePoint& child : childrenOf(Diamond(diamond)))
        if (isSplit(child))
            return false;
    return true;
}

void Front::split(const LatticePoint& diamond)
{
    ISOFRONT_ASSERT(isComplete(diamond), "only a diamond whose parents are all split can be split");
    const DiamondTetrahedra all = tetrahedraOf(Diamond(diamond));
    _nodes[diamond] = {0, true};
    _cellCount -= all.size();
    ++_splitCount;
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const Tetrahedron& half : all.tetrahedron(i).bisected())
            add(cellIdOf(half));
}

void Front::merge(const LatticePoint& diamond)
{
    ISOFRONT_ASSERT(isMergeable(diamond), "only a diamond with no split child can be merged");
    const DiamondTetrahedra all = tetrahedraOf(Diamond(diamond));
    for (std::size_t i = 0; i < all.size(); ++i)
        for (const Tetrahedron& half : all.tetrahedron(i).bisected())
            remove(cellIdOf(half));
    _nodes[diamond] = {all.mask(), false};
    _cellCount += all.size();
    --_splitCount;
}

std::vector<LatticePoint> Front::closureOf(const LatticePoint& diamond) const
{
    std::vector<LatticePoint> order;
    if (isSplit(diamond))
        return order;
    const LatticePoints parents = parentsOf(Diamond(diamond));
    if (std::all_of(parents.begin(), parents.end(), [&](const auto& p) { return isSplit(p); })) {
        order.push_back(diamond);
        return order;
    }
    // Depth first without recursion: a diamond is listed once all its parents are.
    std::unordered_set<LatticePoint, LatticePointHash> listed;
    std::vector<LatticePoint> stack{diamond};
    while (!stack.empty()) {
        const LatticePoint top = stack.back();
        if (listed.contains(top)) {
            stack.pop_back();
            continue;
        }
        bool ready = true;
        for (const LatticePoint& parent : parentsOf(Diamond(top)))
            if (!isSplit(parent) && !listed.contains(parent)) {
                stack.push_back(parent);
                ready = false;
            }
        if (ready) {
            stack.pop_back();
            listed.insert(top);
            order.push_back(top);
        }
    }
    return order;
}

std::vector<LatticePoint> Front::refine(const LatticePoint& diamond)
{
    std::vector<LatticePoint> order = closureOf(diamond);
    for (const LatticePoint& next : order)
        split(next);
    return order;
}

std::vector<FrontDiamond> Front::diamondsWithCells() const
{
    std::vector<FrontDiamond> diamonds;
    diamonds.reserve(_nodes.size());
    _nodes.forEach([&](const Nodes::Entry& entry) {
        if (entry.second.present != 0)
            diamonds.push_back({entry.first, entry.second.present});
    });
    return diamonds;
}

std::vector<LatticePoint> Front::diamonds() const
{
    std::vector<LatticePoint> diamonds;
    diamonds.reserve(_nodes.size());
    forEachDiamond([&](const LatticePoint& centre) { diamonds.push_back(centre); });
    return diamonds;
}

std::size_t Front::bytes() const
{
    return _nodes.bytes();
}

bool Front::operator==(const Front& other) const
{
    bool same = _nodes.size() == other._nodes.size();
    _nodes.forEach([&](const Nodes::Entry& entry) {
        const Node* node = other._nodes.find(entry.first);
        same = same && node != nullptr && *node == entry.second;
    });
    return same;
}

void Front::add(const CellId& id)
{
    Node& node = _nodes[id.spine];
    ISOFRONT_ASSERT((unsigned{node.present} >> id.index & 1U) == 0, "the cell is there already");
    node.present = static_cast<std::uint8_t>(node.present | (1U << id.index));
    ++_cellCount;
}

void Front::remove(const CellId& id)
{
    Node* node = _nodes.find(id.spine);
    ISOFRONT_ASSERT(node != nullptr, "the cell is not on the front");
    node->present = static_cast<std::uint8_t>(node->present & ~(1U << id.index));
    --_cellCount;
    if (node->present == 0 && !node->split)
        _nodes.erase(id.spine);
}

} // namespace isofront::hierarchy
