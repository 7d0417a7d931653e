#pragma once

#include "SurfaceGrowth.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Diamond.h>
#include <isofront/hierarchy/Front.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <stop_token>
#include <vector>

namespace isofront::surface {

/// Refines a front wherever that is wanted and there may be a surface: wave after wave of diamonds,
/// whose bounds are taken by all threads. Which front results doesn't depend on the order of
/// splits.
///
/// Thread: one at a time.
class FrontFinder {
public:
    using MaybeError = std::optional<core::Error>;

    /// @param stop  makes what bounds say meaningless, and ends the work soon
    FrontFinder(
        const extractor::CellExtractor& extractor, core::Jobs& jobs, const std::stop_token& stop)
        : _extractor(extractor), _jobs(jobs), _stop(stop)
    {
    }

    /// Called between blocks of diamonds with the memory held [bytes] and the coarsest level that
    /// is being looked at. An error ends the work.
    using Check = std::function<MaybeError(std::size_t, int)>;

    /// @param maxLevel  no diamond of this level is split
    /// @param isWanted  whether a diamond is to be split, as far as the field has no say
    MaybeError refine(
        hierarchy::Front& front,
        int maxLevel,
        const std::function<bool(const hierarchy::Diamond&)>& isWanted,
        const Check& check);

    /// For each diamond, whether bounds prove that no triangle can arise in it.
    [[nodiscard]] std::vector<std::uint8_t>
    provedEmpty(const std::vector<hierarchy::LatticePoint>& diamonds) const;

    /// What has been split because it was wanted.
    [[nodiscard]] const SurfaceGrowth& growth() const { return _growth; }

private:
    const extractor::CellExtractor& _extractor;
    core::Jobs& _jobs;
    std::stop_token _stop;
    SurfaceGrowth _growth;
};

} // namespace isofront::surface
