#include "DeviceCache.h"

#include <isofront/core/Assert.h>

#include <algorithm>

namespace isofront::voxels {

namespace {

/// Of the capacity, at least, is set aside.
constexpr std::uint64_t kShareSetAside = 20;

} // namespace

DeviceCache::DeviceCache(std::uint64_t capacity, std::uint64_t root, std::uint64_t largest)
    : _capacity(capacity / kChunkAlignment * kChunkAlignment)
{
    const std::uint64_t setAside =
        std::max(alignedBytes(largest), alignedBytes(_capacity / kShareSetAside));
    _usable = std::max(alignedBytes(root), _capacity > setAside ? _capacity - setAside : 0);
    _free.emplace(0, _capacity);
}

void DeviceCache::begin(std::uint64_t frame, std::uint64_t completed)
{
    _frame = frame;
    _completed = completed;
    std::erase_if(_pending, [&](const Pending& range) {
        if (range.frame > completed)
            return false;
        _pendingBytes -= range.bytes;
        giveFree(range.offset, range.bytes);
        return true;
    });
}

std::optional<std::uint64_t> DeviceCache::allocate(ChunkIndex index, std::uint64_t bytes)
{
    ISOFRONT_ASSERT(!contains(index), "chunk " + std::to_string(index) + " has a place already");
    const std::uint64_t needed = alignedBytes(bytes);
    for (const auto& [begin, length] : _free) {
        const std::uint64_t end = std::min(begin + length, _usable);
        if (begin < _gapEnd || begin >= end || end - begin < needed)
            continue;
        const std::uint64_t offset = begin;
        takeFree(offset, needed);
        _places[index] = {offset, needed, _frame};
        _byOffset[offset] = index;
        _used += needed;
        return offset;
    }
    return std::nullopt;
}

void DeviceCache::release(ChunkIndex index)
{
    const auto found = _places.find(index);
    ISOFRONT_ASSERT(found != _places.end(), "chunk " + std::to_string(index) + " has no place");
    const Place place = found->second;
    _places.erase(found);
    _byOffset.erase(place.offset);
    std::erase(_waiting, index);
    _used -= place.bytes;
    retire(place.offset, place.bytes, place.lastUse);
}

void DeviceCache::makeRoom(std::uint64_t bytes)
{
    _roomWanted = alignedBytes(bytes);
    if (_isDefragmenting)
        return;
    _isDefragmenting = true;
    _packed = 0;
}

std::vector<ChunkMove> DeviceCache::move(std::uint64_t mostBytes, ChunkIndex pinned)
{
    std::vector<ChunkMove> moves;
    std::uint64_t bytes = 0;
    const auto mayMove = [&](std::uint64_t size) {
        return bytes == 0 || bytes + size <= mostBytes;
    };
    // first those that wait, down to where everything is packed
    while (!_waiting.empty()) {
        const std::uint64_t size = _places.at(_waiting.front()).bytes;
        if (_waiting.front() == pinned || !mayMove(size) || !isFree(_packed, size))
            return moves;
        moves.push_back(moved(_waiting.front(), _packed));
        bytes += size;
        _packed += size;
        _waiting.erase(_waiting.begin());
    }
    _gapEnd = 0;
    while (_isDefragmenting) {
        const auto next = _byOffset.lower_bound(_packed);
        if (next == _byOffset.end() || next->first >= _usable || longestFree() >= _roomWanted) {
            _isDefragmenting = !_waiting.empty();
            break;
        }
        const auto [offset, index] = *next;
        const std::uint64_t size = _places.at(index).bytes;
        if (offset == _packed && _waiting.empty()) {
            _packed += size;
            continue;
        }
        if (index == pinned || !mayMove(size))
            break;
        if (_waiting.empty() && isFree(_packed, size)) {
            moves.push_back(moved(index, _packed));
            bytes += size;
            _packed += size;
            continue;
        }
        // out of the way, into what is set aside
        const auto aside = std::ranges::find_if(_free, [&](const auto& range) {
            const std::uint64_t begin = std::max(range.first, _usable);
            const std::uint64_t end = range.first + range.second;
            return begin < end && end - begin >= size;
        });
        if (aside == _free.end())
            break;
        moves.push_back(moved(index, std::max(aside->first, _usable)));
        bytes += size;
        _waiting.push_back(index);
        _gapEnd = offset + size;
    }
    return moves;
}

ChunkMove DeviceCache::moved(ChunkIndex index, std::uint64_t to)
{
    Place& place = _places.at(index);
    const ChunkMove move{index, place.offset, to, place.bytes};
    takeFree(to, place.bytes);
    _byOffset.erase(place.offset);
    _byOffset[to] = index;
    place.offset = to;
    place.lastUse = _frame;
    retire(move.from, move.bytes, _frame);
    return move;
}

bool DeviceCache::isFree(std::uint64_t offset, std::uint64_t bytes) const
{
    auto range = _free.upper_bound(offset);
    if (range == _free.begin())
        return false;
    --range;
    return offset + bytes <= range->first + range->second;
}

/// Of the ranges that may be given to chunks.
std::uint64_t DeviceCache::longestFree() const
{
    std::uint64_t longest = 0;
    for (const auto& [begin, length] : _free)
        if (begin < _usable && begin >= _gapEnd)
            longest = std::max(longest, std::min(begin + length, _usable) - begin);
    return longest;
}

void DeviceCache::takeFree(std::uint64_t offset, std::uint64_t bytes)
{
    const auto range = std::prev(_free.upper_bound(offset));
    const auto [begin, length] = *range;
    ISOFRONT_ASSERT(
        offset + bytes <= begin + length, "offset " + std::to_string(offset) + " is not free");
    _free.erase(range);
    if (begin < offset)
        _free[begin] = offset - begin;
    if (offset + bytes < begin + length)
        _free[offset + bytes] = begin + length - (offset + bytes);
}

void DeviceCache::giveFree(std::uint64_t offset, std::uint64_t bytes)
{
    const auto after = _free.lower_bound(offset);
    if (after != _free.end() && after->first == offset + bytes) {
        bytes += after->second;
        _free.erase(after);
    }
    const auto from = _free.lower_bound(offset);
    if (from != _free.begin()) {
        const auto before = std::prev(from);
        if (before->first + before->second == offset) {
            before->second += bytes;
            return;
        }
    }
    _free[offset] = bytes;
}

void DeviceCache::retire(std::uint64_t offset, std::uint64_t bytes, std::uint64_t lastUse)
{
    if (lastUse <= _completed) {
        giveFree(offset, bytes);
        return;
    }
    _pending.push_back({offset, bytes, lastUse});
    _pendingBytes += bytes;
}

} // namespace isofront::voxels
