#pragma once

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/CellId.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/surface/DetailSettings.h>

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <unordered_map>

namespace isofront::surface {

/// The distance between mesh and unfiltered surface to expect (root of the mean square), as a share
/// of the lattice's axis step: what detail is chosen by before anything is extracted. Measured on
/// the terrain presets, 0.10 to 0.16 unfiltered and 0.16 to 0.29 with a filter of one half: see
/// docs/measurements.md.
inline constexpr double kErrorPerStep = 0.25;

/// Distance error to expect in a cell of that level, before it is extracted [world].
double expectedError(int level, int latticeSize, const hierarchy::Domain& domain);

/// A box that holds a diamond's tetrahedra [field].
core::Box boxOf(const hierarchy::Diamond& diamond, const hierarchy::Domain& domain);

/// What the field's bounds say about diamonds, remembered: a diamond is asked about again and again
/// as the viewer and the isovalue change, and bounds cost far more than this.
///
/// Thread: one at a time; `find` any number while nobody else calls.
class DiamondBounds {
public:
    /// @param extractor  of any isovalue, but always of the same field, domain and other settings
    const extractor::BoxBounds&
    of(const hierarchy::Diamond& diamond, const extractor::CellExtractor& extractor);
    /// Null if it isn't remembered.
    [[nodiscard]] const extractor::BoxBounds* find(const hierarchy::LatticePoint& centre) const;
    /// Memory held, about [bytes].
    [[nodiscard]] std::size_t bytes() const;

private:
    std::unordered_map<hierarchy::LatticePoint, extractor::BoxBounds, hierarchy::LatticePointHash>
        _known;
};

/// The errors of cells that have been extracted, as they were estimated then.
///
/// Thread: one at a time.
class MeasuredErrors {
public:
    /// Remembers what the extraction of a cell found.
    /// @param stretch  of the domain's map
    void record(const hierarchy::CellId& id, const extractor::CellMesh& mesh, double stretch);
    [[nodiscard]] bool isKnown(const hierarchy::CellId& id) const;
    /// Of a cell without triangles: true if it is known that the field's bounds prove it empty.
    [[nodiscard]] bool isProvedEmpty(const hierarchy::CellId& id) const;
    /// Largest error of some cells of a diamond, and whether all of them are known. Infinite where
    /// a cell without triangles has not been proved empty: what it missed can't be told.
    struct Error {
        double largest = 0; ///< [world]
        bool complete = false;
    };
    [[nodiscard]] Error of(const hierarchy::LatticePoint& centre, std::uint8_t cells) const;
    /// Memory held, about [bytes].
    [[nodiscard]] std::size_t bytes() const;

private:
    /// By the cell's index in its diamond; NaN while unknown.
    using Errors = std::array<float, 8>;

    std::unordered_map<hierarchy::LatticePoint, Errors, hierarchy::LatticePointHash> _known;
};

/// Another criterion where there may be a surface, and no refinement where the field's bounds prove
/// that there is none.
///
/// Thread: one at a time.
class WhereSurface final : public hierarchy::Criterion {
public:
    /// @param known     what bounds have said already, shared; null to begin with nothing
    /// @param maxLevel  no diamond of this level is split
    WhereSurface(
        hierarchy::CriterionPointer criterion,
        std::shared_ptr<const extractor::CellExtractor> extractor,
        std::shared_ptr<DiamondBounds> known = nullptr,
        int maxLevel = hierarchy::kMaxLevel)
        : _criterion(std::move(criterion)), _extractor(std::move(extractor)),
          _known(known ? std::move(known) : std::make_shared<DiamondBounds>()), _maxLevel(maxLevel)
    {
    }

    [[nodiscard]] bool provesEmpty(const hierarchy::Diamond& diamond) const;
    /// Memory held by what is known, about [bytes].
    [[nodiscard]] std::size_t bytes() const { return _known->bytes(); }

private:
    [[nodiscard]] double
    judge(const hierarchy::Diamond& diamond, hierarchy::DiamondState state) const override;

    hierarchy::CriterionPointer _criterion;
    std::shared_ptr<const extractor::CellExtractor> _extractor;
    std::shared_ptr<DiamondBounds> _known;
    int _maxLevel;
};

/// The error to expect in a diamond: by its level, and less where its cells have been extracted and
/// found better.
///
/// Never more than the level's and never less than that of the level `measuredLevels` further down,
/// so that a cell that missed something is not believed for long. While cells of a whole diamond
/// are unknown, the least is assumed for its splitting, and the most for its merging.
/// @param measured  null to go by the level alone
hierarchy::ErrorEstimate errorEstimate(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    std::shared_ptr<const MeasuredErrors> measured = nullptr,
    int measuredLevels = 0);

/// The criterion of a picture: the error, projected, is at most `pixels`, and all that the settings
/// ask for beside, whether or not there is a surface. See `viewCriterion`.
hierarchy::CriterionPointer detailCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const DetailSettings& settings,
    std::shared_ptr<const MeasuredErrors> measured,
    double coarser);

/// No diamond of this level is to be split where `maxLevel` is the finest that was asked for, and
/// errors are allowed to be so many times larger.
int coarserLevel(int maxLevel, double coarser);

/// The same where there may be a surface: the error, projected, is at most `pixels`, and all that
/// the settings ask for beside.
/// @param pixelsPerUnit  of the view, see hierarchy::View::pixelsPerUnit
/// @param coarser        allows so many times the errors that are asked for, everywhere
/// @param maxLevel       no finer than this, and by `coarser` coarser than it: around the eye,
/// where
///                       no error is small enough, nothing else would bound the front
std::shared_ptr<const WhereSurface> viewCriterion(
    const std::shared_ptr<const extractor::CellExtractor>& extractor,
    double pixelsPerUnit,
    double pixels,
    const DetailSettings& settings = {},
    std::shared_ptr<DiamondBounds> known = nullptr,
    std::shared_ptr<const MeasuredErrors> measured = nullptr,
    double coarser = 1,
    int maxLevel = hierarchy::kMaxLevel);

/// One level wherever there may be a surface.
std::shared_ptr<const WhereSurface>
levelCriterion(const std::shared_ptr<const extractor::CellExtractor>& extractor, int level);

} // namespace isofront::surface
