#include "ChunkSelection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <tuple>

namespace isofront::voxels {

namespace {

/// Frames whose visibility may still come. Later it says nothing any more.
constexpr std::size_t kMostRecords = 16;
/// A chunk that was opened by its test isn't closed again within so many frames, or a moving view
/// would let it alternate.
constexpr std::uint64_t kKeptOpen = 8;

void sortFrontToBack(std::vector<ChunkDraw>& draws)
{
    std::ranges::sort(draws, [](const ChunkDraw& a, const ChunkDraw& b) {
        return std::tie(a.occlusionOnly, a.distance, a.index) <
               std::tie(b.occlusionOnly, b.distance, b.index);
    });
}

} // namespace

ChunkSelection::ChunkSelection(const ChunkTree& tree, const StreamingSettings& settings)
    : _tree(tree), _settings(settings), _nodes(tree.size())
{
}

void ChunkSelection::begin(const ChunkView& view, const ChunkTurn& turn)
{
    if (_viewVersion == 0 || view != _view)
        ++_viewVersion;
    _view = view;
    _turn = turn;
    ++_tick;
}

bool ChunkSelection::isForced(ChunkIndex index) const
{
    const auto found = _damaged.find(index);
    return found != _damaged.end() && !found->second.standIn;
}

const core::Box& ChunkSelection::boxOf(ChunkIndex index) const
{
    const auto found = _damaged.find(index);
    return found == _damaged.end() ? _tree[index].box : found->second.box;
}

double ChunkSelection::pixelsOf(ChunkIndex index, double distance) const
{
    return _tree.voxelEdge(_tree[index].entry.key.level) * _view.pixelsPerUnit / distance;
}

bool ChunkSelection::needsRefinement(ChunkIndex index, double pixels, double coarsening) const
{
    return !_tree[index].isLeaf && (isForced(index) || pixels > _settings.voxelPixels * coarsening);
}

bool ChunkSelection::isClosed(ChunkIndex index) const
{
    // one that was out of view in between may show anything
    const Node& node = _nodes[index];
    return node.isClosed && node.visited + 1 >= _tick && !isForced(index) && !_isSecondPass;
}

bool ChunkSelection::isCovered(ChunkIndex index) const
{
    return _turn.isCovered && _turn.isCovered(_tree[index]);
}

void ChunkSelection::wanted(double coarsening, std::vector<Wanted>& chunks) const
{
    chunks.clear();
    if (_tree.size() == 0)
        return;
    // the root, even if it is out of view: everything starts from it
    chunks.push_back({0, distanceTo(0)});
    for (std::size_t at = mayShow(0) ? 0 : 1; at < chunks.size(); ++at) {
        const Wanted chunk = chunks[at];
        const double pixels = pixelsOf(chunk.index, chunk.distance);
        if (!needsRefinement(chunk.index, pixels, coarsening) || isClosed(chunk.index))
            continue;
        for (const ChunkIndex child : _tree[chunk.index].children)
            if (child != kNoChunk && mayShow(child) &&
                !(_turn.isUnneeded && _turn.isUnneeded(_tree[child])))
                chunks.push_back({child, distanceTo(child)});
    }
    std::erase_if(chunks, [&](const Wanted& chunk) { return isForced(chunk.index); });
    std::ranges::sort(chunks, [&](const Wanted& a, const Wanted& b) {
        const std::uint32_t levelA = _tree[a.index].entry.key.level;
        const std::uint32_t levelB = _tree[b.index].entry.key.level;
        return std::tie(levelB, a.distance, a.index) < std::tie(levelA, b.distance, b.index);
    });
}

void ChunkSelection::kept(std::vector<ChunkIndex>& chunks) const
{
    chunks.clear();
    if (_turn.begins && _turn.weight >= 1)
        return;
    const Pictures pictures = _turn.begins ? kPresent : kBoth;
    std::ranges::copy_if(_visited, std::back_inserter(chunks), [&](ChunkIndex index) {
        return (_nodes[index].reached & pictures) != 0 && mayShow(index);
    });
}

void ChunkSelection::enter(ChunkIndex index)
{
    Node& node = _nodes[index];
    if (node.visited == _tick)
        return;
    _visited.push_back(index);
    if (node.visited + 1 != _tick) {
        node.seen = _tick;
        node.isClosed = false;
    }
    node.visited = _tick;
}

void ChunkSelection::draw(
    ChunkIndex index,
    double distance,
    double pixels,
    bool isTest,
    Pictures pictures,
    std::vector<ChunkDraw>& draws)
{
    Node& node = _nodes[index];
    if (!isTest && isCovered(index)) {
        node.seen = _tick; // nobody knows
        if ((pictures & kPresent) != 0)
            _covered.push_back({index, _tree[index].entry.key.level});
        return;
    }
    if (node.drawn + 1 != _tick || node.wasTested != isTest || pictures != kBoth)
        node.since = _tick;
    node.drawn = _tick;
    node.wasTested = isTest;
    const ChunkTree::Node& chunk = _tree[index];
    ChunkDraw draw;
    draw.key = chunk.entry.key;
    draw.index = index;
    draw.voxels = chunk.entry.voxels;
    draw.distance = distance;
    draw.voxelPixels = pixels;
    if (const auto damaged = _damaged.find(index);
        damaged != _damaged.end() && damaged->second.standIn) {
        draw.standIn = &*damaged->second.standIn;
        draw.key = draw.standIn->key;
        draw.voxels = draw.standIn->voxels;
        draw.voxelPixels =
            std::ldexp(pixels, static_cast<int>(draw.key.level - chunk.entry.key.level));
    }
    const double bound = _settings.voxelPixels * _coarsening;
    draw.weight = static_cast<float>(std::clamp(2 * pixels / bound - 1, 0.0, 1.0));
    draw.occlusionOnly = isTest;
    draw.inFormer = (pictures & kFormer) != 0;
    draw.inPresent = (pictures & kPresent) != 0;
    draw.needsSource = !isTest && chunk.isLeaf && draw.voxelPixels > _settings.sourcePixels;
    draws.push_back(draw);
}

ChunkSelection::Children
ChunkSelection::childrenInView(ChunkIndex index, const IsThere& isThere) const
{
    Children children;
    std::size_t inView = 0;
    for (const ChunkIndex child : _tree[index].children) {
        if (child == kNoChunk || !mayShow(child))
            continue;
        const bool isReady = isThere(child) || isForced(child);
        if (isReady)
            children.ready[children.count++] = child;
        inView += isReady || !isCovered(child) ? 1U : 0U;
    }
    children.areAll = children.count == inView;
    children.mayStandIn = children.areAll || isForced(index) ||
                          (_settings.policy == StreamingPolicy::partial && children.count > 0);
    return children;
}

void ChunkSelection::listMissing(ChunkIndex index, Pictures pictures, const IsThere& isThere)
{
    for (const ChunkIndex child : _tree[index].children) {
        if (child == kNoChunk || !mayShow(child) || isThere(child) || isForced(child) ||
            !isCovered(child))
            continue;
        _nodes[index].seen = _tick;
        if ((pictures & kPresent) != 0)
            _covered.push_back({child, _tree[index].entry.key.level});
    }
}

/// In which pictures a chunk's children stand for it.
/// @param before      the same in the last frame
/// @param best        what would be decided now
/// @param isPossible  whether they can
ChunkSelection::Pictures
ChunkSelection::decided(Pictures before, Pictures best, bool isPossible) const
{
    const Pictures kept = isPossible ? before : 0;
    if (!_turn.begins)
        return kept;
    if (_turn.weight >= 1)
        return best;
    return (best & kPresent) | ((kept & kPresent) != 0 ? kFormer : 0);
}

/// @param pictures  those that it, or what stands for it, is part of
/// @return when the chunk, or anything that stands for it, was last seen
ChunkSelection::Tick ChunkSelection::visit(
    ChunkIndex index, Pictures pictures, const IsThere& isThere, std::vector<ChunkDraw>& draws)
{
    Node& node = _nodes[index];
    // Of what wasn't present, nothing is left when a transition begins.
    const bool isKnown = node.visited + 1 == _tick && node.isDecided && !isForced(index) &&
                         (!_turn.begins || (node.reached & kPresent) != 0);
    enter(index);
    node.reached = pictures;
    const double distance = distanceTo(index);
    const double pixels = pixelsOf(index, distance);
    const bool refines = needsRefinement(index, pixels, _coarsening);
    node.isDecided = !(refines && isClosed(index));
    if (!node.isDecided) {
        draw(index, distance, pixels, true, pictures, draws);
        return node.seen;
    }
    node.isClosed = false;
    Children children;
    if (refines || (isKnown && node.expanded != 0))
        children = childrenInView(index, isThere);
    const Pictures best = refines && children.mayStandIn ? kBoth : 0;
    node.expanded = isKnown ? decided(node.expanded, best, children.mayStandIn) : best;
    _isChanging |= ((node.expanded ^ best) & pictures) != 0;
    const Pictures below = node.expanded & pictures;
    if (below != 0) {
        for (std::size_t i = 0; i < children.count; ++i)
            node.seen = std::max(node.seen, visit(children.ready[i], below, isThere, draws));
        if (_turn.isCovered)
            listMissing(index, below, isThere);
    }
    if (below == kBoth && children.areAll)
        node.open = _tick;
    // one that is damaged, and has nothing below it, isn't drawn at all
    if (below != pictures && !isForced(index))
        draw(index, distance, pixels, false, pictures & ~below, draws);
    return node.seen;
}

std::size_t ChunkSelection::draws(
    std::uint64_t frame, double coarsening, const IsThere& isThere, std::vector<ChunkDraw>& draws)
{
    draws.clear();
    _visited.clear();
    _covered.clear();
    _isChanging = false;
    _coarsening = coarsening;
    if (_tree.size() > 0 && mayShow(0) && (isThere(0) || isForced(0)))
        visit(0, kBoth, isThere, draws);
    sortFrontToBack(draws);
    const auto opaque =
        static_cast<std::size_t>(std::ranges::count(draws, false, &ChunkDraw::occlusionOnly));
    Record& record = _records.emplace_back();
    record.frame = frame;
    record.tick = _tick;
    for (const ChunkDraw& draw : draws)
        record.chunks.push_back(draw.index);
    record.firstTested = opaque;
    record.lastTested = draws.size();
    if (_records.size() > kMostRecords)
        _records.pop_front();
    return opaque;
}

void ChunkSelection::secondPass(
    std::span<const std::uint32_t> visible, const IsThere& isThere, std::vector<ChunkDraw>& draws)
{
    draws.clear();
    if (_records.empty() || _records.back().tick != _tick)
        return;
    Record& record = _records.back();
    _isSecondPass = true;
    const std::size_t last = std::min(visible.size(), record.lastTested);
    for (std::size_t i = record.firstTested; i < last; ++i) {
        if (visible[i] == 0)
            continue;
        const ChunkIndex index = record.chunks[i];
        open(index);
        markSeen(index, _tick);
        visit(index, _nodes[index].reached, isThere, draws);
    }
    _isSecondPass = false;
    sortFrontToBack(draws);
    for (const ChunkDraw& draw : draws)
        record.chunks.push_back(draw.index);
}

void ChunkSelection::markSeen(ChunkIndex index, Tick tick)
{
    // what was closed since, because it was hidden before, is opened again
    for (; index != kNoChunk && _nodes[index].seen < tick; index = _tree[index].parent) {
        _nodes[index].seen = tick;
        _nodes[index].isClosed = false;
    }
}

void ChunkSelection::open(ChunkIndex index)
{
    Node& node = _nodes[index];
    node.isClosed = false;
    node.keptOpen = _tick + kKeptOpen;
    node.keptOpenView = _viewVersion;
}

void ChunkSelection::learn(const Visibility& seen)
{
    if (!_settings.occlusion)
        return;
    while (!_records.empty() && _records.front().frame < seen.frame)
        _records.pop_front();
    if (_records.empty() || _records.front().frame != seen.frame ||
        _records.front().chunks.size() != seen.visible.size())
        return;
    const Record record = std::move(_records.front());
    _records.pop_front();
    for (std::size_t i = 0; i < record.chunks.size(); ++i) {
        if (seen.visible[i] == 0)
            continue;
        const ChunkIndex index = record.chunks[i];
        markSeen(index, record.tick);
        if (i >= record.firstTested && i < record.lastTested)
            open(index);
    }
    closeHidden(record);
}

/// Closes what has been open, and all of whose children were hidden, as far as it is known.
void ChunkSelection::closeHidden(const Record& record)
{
    const Tick last = _tick - 1; // of the latest draws: this frame's are yet to come
    for (const ChunkIndex drawn : record.chunks) {
        const ChunkIndex parent = _tree[drawn].parent;
        if (parent == kNoChunk)
            continue;
        Node& node = _nodes[parent];
        if (node.isClosed || node.open != last || isForced(parent) ||
            node.seen + std::max(1U, _settings.hiddenFrames) > record.tick ||
            node.keptOpenView == _viewVersion || node.keptOpen > _tick)
            continue;
        const bool isHidden = std::ranges::all_of(_tree[parent].children, [&](ChunkIndex child) {
            if (child == kNoChunk)
                return true;
            if (_nodes[child].visited != last) // what comes into view may be visible
                return !mayShow(child);
            const Node& other = _nodes[child];
            return other.drawn == last && other.since <= record.tick;
        });
        if (isHidden)
            node.isClosed = true;
    }
}

void ChunkSelection::markDamaged(ChunkIndex index, const ChunkEntry* standIn)
{
    Damaged& damaged = _damaged[index];
    damaged.box = _tree[index].box;
    damaged.standIn.reset();
    if (standIn == nullptr)
        return;
    damaged.standIn = *standIn;
    const core::Box box = _tree.boxOf(*standIn);
    damaged.box.include(box.low);
    damaged.box.include(box.high);
}

} // namespace isofront::voxels
