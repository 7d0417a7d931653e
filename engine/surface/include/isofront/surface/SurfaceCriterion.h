#pragma once

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Criterion.h>

#include <memory>
#include <unordered_map>

namespace isofront::surface {

/// The distance between mesh and unfiltered surface to expect (root of the mean square), as a share
/// of the lattice's axis step: what detail is chosen by before anything is extracted. Measured on
/// the terrain presets, 0.10 to 0.17 unfiltered and 0.25 to 0.38 filtered: see
/// docs/measurements.md.
inline constexpr double kErrorPerStep = 0.25;

/// Distance error to expect in a cell of that level, before it is extracted [world].
double expectedError(int level, int latticeSize, const hierarchy::Domain& domain);

/// A box that holds a diamond's tetrahedra [field].
core::Box boxOf(const hierarchy::Diamond& diamond, const hierarchy::Domain& domain);

/// Another criterion where there may be a surface, and no refinement where the field's bounds prove
/// that there is none.
///
/// Thread: one at a time.
class WhereSurface final : public hierarchy::Criterion {
public:
    /// @param known  if not null, another one of the same extractor, whose knowledge is shared
    WhereSurface(
        std::shared_ptr<const hierarchy::Criterion> criterion,
        std::shared_ptr<const extractor::CellExtractor> extractor,
        const WhereSurface* known = nullptr)
        : _criterion(std::move(criterion)), _extractor(std::move(extractor)),
          _known(known != nullptr ? known->_known : std::make_shared<Known>())
    {
    }

    [[nodiscard]] double refineDistance(const hierarchy::Diamond& diamond) const override;
    [[nodiscard]] bool provesEmpty(const hierarchy::Diamond& diamond) const;
    /// Memory held by what is known, about [bytes].
    [[nodiscard]] std::size_t bytes() const;

private:
    using Known = std::unordered_map<hierarchy::LatticePoint, bool, hierarchy::LatticePointHash>;

    std::shared_ptr<const hierarchy::Criterion> _criterion;
    std::shared_ptr<const extractor::CellExtractor> _extractor;
    /// A diamond is asked about again and again as the viewer moves; bounds cost far more than
    /// this.
    std::shared_ptr<Known> _known;
};

/// The criterion of a view: the expected error, projected, is at most `pixels`.
/// @param known  if not null, an earlier one of the same extractor, whose knowledge is shared
std::shared_ptr<const WhereSurface> viewCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const WhereSurface* known = nullptr);

/// One level wherever there may be a surface.
std::shared_ptr<const WhereSurface>
levelCriterion(const std::shared_ptr<const extractor::CellExtractor>& extractor, int level);

} // namespace isofront::surface
