#pragma once

#include "support/Random.h"

#include <isofront/hierarchy/Front.h>

#include <algorithm>
#include <vector>

namespace isofront::tests {

/// A conforming front of mixed levels: everything down to `coarsest`, then random splits, some of
/// them of ever deeper diamonds around one place.
template <typename Generator>
hierarchy::Front randomFront(Generator& generator, int coarsest, int deepest, std::size_t splits)
{
    using hierarchy::Diamond;
    using hierarchy::LatticePoint;
    hierarchy::Front front;
    const auto leaves = [&](auto&& wanted) {
        std::vector<LatticePoint> result;
        front.forEachDiamond([&](const LatticePoint& centre) {
            if (!front.isSplit(centre) && wanted(Diamond(centre)))
                result.push_back(centre);
        });
        std::ranges::sort(result);
        return result;
    };
    for (int level = 0; level < coarsest; ++level)
        for (const LatticePoint& centre :
             leaves([&](const Diamond& d) { return d.level <= level; }))
            front.refine(centre);
    for (std::size_t i = 0; i < splits; ++i) {
        const auto all = leaves([&](const Diamond& d) { return d.level < deepest; });
        if (all.empty())
            break;
        LatticePoint chosen = all[below(generator, all.size())];
        for (std::size_t dive = below(generator, 4); dive > 0; --dive) {
            front.refine(chosen);
            std::vector<LatticePoint> children;
            for (const LatticePoint& child : hierarchy::childrenOf(Diamond(chosen)))
                if (Diamond(child).level < deepest)
                    children.push_back(child);
            if (children.empty())
                break;
            chosen = children[below(generator, children.size())];
        }
        front.refine(chosen);
    }
    return front;
}

/// The front of one level everywhere.
inline hierarchy::Front uniformFront(int level)
{
    auto generator = random(0);
    return randomFront(generator, level, level, 0);
}

} // namespace isofront::tests
