#pragma once

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Criterion.h>

#include <memory>
#include <unordered_map>

namespace isofront::surface {

/// How far a mesh lies from the surface it stands for, as a share of the lattice's axis step: what
/// detail is chosen by before anything is extracted. Measured on the terrain presets: see
/// docs/measurements.md.
inline constexpr double kErrorPerStep = 0.25;

/// Distance error to expect in a cell of that level, before it is extracted [world].
double expectedError(int level, int latticeSize, const hierarchy::Domain& domain);

/// Another criterion where there may be a surface, and no refinement where the field's bounds prove
/// that there is none.
///
/// Thread: one at a time.
class WhereSurface final : public hierarchy::Criterion {
public:
    WhereSurface(
        std::shared_ptr<const hierarchy::Criterion> criterion,
        std::shared_ptr<const extractor::CellExtractor> extractor)
        : _criterion(std::move(criterion)), _extractor(std::move(extractor))
    {
    }

    [[nodiscard]] double refineDistance(const hierarchy::Diamond& diamond) const override;
    [[nodiscard]] bool provesEmpty(const hierarchy::Diamond& diamond) const;

private:
    std::shared_ptr<const hierarchy::Criterion> _criterion;
    std::shared_ptr<const extractor::CellExtractor> _extractor;
    /// A diamond is asked about again and again as the viewer moves; bounds cost far more than
    /// this.
    mutable std::unordered_map<hierarchy::LatticePoint, bool, hierarchy::LatticePointHash> _known;
};

/// The criterion of a view: the expected error, projected, is at most `pixels`.
std::shared_ptr<const hierarchy::Criterion> viewCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels);

/// One level wherever there may be a surface.
std::shared_ptr<const hierarchy::Criterion>
levelCriterion(const std::shared_ptr<const extractor::CellExtractor>& extractor, int level);

} // namespace isofront::surface
