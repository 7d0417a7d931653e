#include "isofront/gpu/SlabPool.h"

#include <isofront/core/Assert.h>

#include <algorithm>
#include <string>

namespace isofront::gpu {

SlabPool::SlabPool(std::uint32_t slabs, std::uint32_t slabUnits)
    : _slabUnits(slabUnits), _freeSlabs(slabs), _slabs(slabs)
{
    ISOFRONT_ASSERT(
        slabs > 0 && slabUnits > 0 && std::uint64_t{slabs} * slabUnits < (1ULL << 32U),
        std::to_string(slabs) + " slabs of " + std::to_string(slabUnits) + " units");
    _freeRuns.emplace(0, slabs);
}

std::uint32_t SlabPool::largestGap(const Slab& slab)
{
    std::uint32_t largest = 0;
    for (const Gap& gap : slab.gaps)
        largest = std::max(largest, gap.count);
    return largest;
}

std::optional<std::uint32_t> SlabPool::takeFree(std::uint32_t slabs)
{
    const auto run = std::find_if(_freeRuns.begin(), _freeRuns.end(), [&](const auto& entry) {
        return entry.second >= slabs;
    });
    if (run == _freeRuns.end())
        return std::nullopt;
    const auto [first, count] = *run;
    _freeRuns.erase(run);
    if (count > slabs)
        _freeRuns.emplace(first + slabs, count - slabs);
    _freeSlabs -= slabs;
    return first;
}

void SlabPool::giveFree(std::uint32_t first, std::uint32_t slabs)
{
    _freeSlabs += slabs;
    auto next = _freeRuns.lower_bound(first);
    if (next != _freeRuns.end() && next->first == first + slabs) {
        slabs += next->second;
        next = _freeRuns.erase(next);
    }
    if (next != _freeRuns.begin()) {
        const auto before = std::prev(next);
        if (before->first + before->second == first) {
            before->second += slabs;
            return;
        }
    }
    _freeRuns.emplace(first, slabs);
}

void SlabPool::takeFromOpen(std::uint32_t slab)
{
    _open.erase({largestGap(_slabs[slab]), slab});
}

void SlabPool::putIntoOpen(std::uint32_t slab)
{
    const std::uint32_t largest = largestGap(_slabs[slab]);
    if (largest > 0 && !_slabs[slab].isDraining)
        _open.emplace(largest, slab);
}

std::optional<SlabPool::Range> SlabPool::allocate(std::uint32_t units)
{
    if (units == 0)
        return Range{};
    if (units > _slabUnits) {
        const std::uint32_t slabs = (units - 1) / _slabUnits + 1;
        const std::optional<std::uint32_t> first = takeFree(slabs);
        if (!first)
            return std::nullopt;
        for (std::uint32_t i = 0; i < slabs; ++i) {
            _slabs[*first + i].isRun = true;
            _slabs[*first + i].used = _slabUnits;
        }
        _used += slabs * _slabUnits;
        return Range{*first * _slabUnits, units};
    }

    std::uint32_t index = 0;
    if (const auto fit = _open.lower_bound({units, 0}); fit != _open.end()) {
        index = fit->second;
        _open.erase(fit);
    } else {
        const std::optional<std::uint32_t> fresh = takeFree(1);
        if (!fresh)
            return std::nullopt;
        index = *fresh;
        _slabs[index].gaps = {{0, _slabUnits}};
    }
    Slab& slab = _slabs[index];
    // The smallest gap that is large enough.
    auto best = slab.gaps.end();
    for (auto gap = slab.gaps.begin(); gap != slab.gaps.end(); ++gap) {
        if (gap->count >= units && (best == slab.gaps.end() || gap->count < best->count))
            best = gap;
    }
    const Range range{index * _slabUnits + best->first, units};
    best->first += units;
    best->count -= units;
    if (best->count == 0)
        slab.gaps.erase(best);
    slab.used += units;
    _used += units;
    putIntoOpen(index);
    return range;
}

void SlabPool::release(Range range)
{
    if (range.count == 0)
        return;
    ISOFRONT_ASSERT(
        std::uint64_t{range.first} + range.count <= capacity(), "a range outside of the pool");
    const std::uint32_t index = range.first / _slabUnits;
    if (range.count > _slabUnits) {
        const std::uint32_t slabs = (range.count - 1) / _slabUnits + 1;
        for (std::uint32_t i = 0; i < slabs; ++i) {
            ISOFRONT_ASSERT(_slabs[index + i].isRun, "a run that was not allocated");
            _slabs[index + i] = {};
        }
        _used -= slabs * _slabUnits;
        giveFree(index, slabs);
        return;
    }

    Slab& slab = _slabs[index];
    ISOFRONT_ASSERT(
        !slab.isRun && slab.used >= range.count,
        "a range that was not allocated, or twice released");
    takeFromOpen(index);
    slab.used -= range.count;
    _used -= range.count;
    if (slab.used == 0) {
        slab = {};
        giveFree(index, 1);
        return;
    }
    const Gap freed{range.first - index * _slabUnits, range.count};
    auto next = std::find_if(slab.gaps.begin(), slab.gaps.end(), [&](const Gap& gap) {
        return gap.first > freed.first;
    });
    next = slab.gaps.insert(next, freed);
    if (std::next(next) != slab.gaps.end() && next->first + next->count == std::next(next)->first) {
        next->count += std::next(next)->count;
        slab.gaps.erase(std::next(next));
    }
    if (next != slab.gaps.begin() &&
        std::prev(next)->first + std::prev(next)->count == next->first) {
        std::prev(next)->count += next->count;
        slab.gaps.erase(next);
    }
    putIntoOpen(index);
}

std::optional<std::uint32_t> SlabPool::sparsest(std::uint32_t limit) const
{
    std::optional<std::uint32_t> best;
    for (std::uint32_t i = 0; i < slabs(); ++i) {
        const Slab& slab = _slabs[i];
        if (slab.isRun || slab.isDraining || slab.used == 0 || slab.used > limit)
            continue;
        if (!best || slab.used < _slabs[*best].used)
            best = i;
    }
    return best;
}

void SlabPool::drain(std::uint32_t slab)
{
    ISOFRONT_ASSERT(!_slabs[slab].isRun && _slabs[slab].used > 0, "only a shared slab can drain");
    takeFromOpen(slab);
    _slabs[slab].isDraining = true;
}

} // namespace isofront::gpu
