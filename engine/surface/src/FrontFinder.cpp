#include "FrontFinder.h"

#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/FlatMap.h>

#include <algorithm>
#include <limits>
#include <utility>

namespace isofront::surface {

using hierarchy::Diamond;
using hierarchy::LatticePoint;

namespace {

/// Diamonds between two looks at the limits.
constexpr std::size_t kBlock = std::size_t{1} << 14U;
/// Diamonds of one job.
constexpr std::size_t kChunk = 64;

} // namespace

FrontFinder::MaybeError FrontFinder::refine(
    hierarchy::Front& front,
    int maxLevel,
    const std::function<bool(const Diamond&)>& isWanted,
    const Check& check)
{
    core::FlatMap<LatticePoint, bool, hierarchy::LatticePointHash> known(
        hierarchy::kNoLatticePoint);
    std::vector<LatticePoint> wave;
    if (maxLevel > 0 && isWanted(Diamond(hierarchy::kRootDiamond)))
        wave.push_back(hierarchy::kRootDiamond);
    while (!wave.empty()) {
        int coarsest = std::numeric_limits<int>::max();
        for (const LatticePoint& centre : wave)
            coarsest = std::min(coarsest, Diamond(centre).level);
        std::vector<LatticePoint> next;
        for (std::size_t begin = 0; begin < wave.size(); begin += kBlock) {
            const std::vector<LatticePoint> block(
                wave.begin() + static_cast<std::ptrdiff_t>(begin),
                wave.begin() + static_cast<std::ptrdiff_t>(std::min(begin + kBlock, wave.size())));
            const std::vector<std::uint8_t> empty = provedEmpty(block);
            const std::size_t bytes = front.bytes() + known.bytes() +
                                      (wave.capacity() + next.capacity()) * sizeof(LatticePoint);
            if (auto error = check(bytes, coarsest))
                return error;
            for (std::size_t i = 0; i < block.size(); ++i) {
                if (empty[i] != 0)
                    continue;
                _growth.add(Diamond(block[i]).level);
                for (const LatticePoint& split : front.refine(block[i]))
                    for (const LatticePoint& child : hierarchy::childrenOf(Diamond(split))) {
                        const Diamond diamond(child);
                        if (diamond.level < maxLevel && known.tryEmplace(child, true).second &&
                            isWanted(diamond))
                            next.push_back(child);
                    }
            }
        }
        wave = std::move(next);
    }
    return std::nullopt;
}

std::vector<std::uint8_t> FrontFinder::provedEmpty(const std::vector<LatticePoint>& diamonds) const
{
    std::vector<std::uint8_t> empty(diamonds.size());
    _jobs.parallelFor((diamonds.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        if (_stop.stop_requested())
            return;
        for (std::size_t i = chunk * kChunk; i < std::min(diamonds.size(), (chunk + 1) * kChunk);
             ++i) {
            const core::Box box = boxOf(Diamond(diamonds[i]), _extractor.domain());
            empty[i] = _extractor.provesEmpty(box) ? 1 : 0;
        }
    });
    return empty;
}

} // namespace isofront::surface
