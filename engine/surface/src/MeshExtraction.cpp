#include "isofront/surface/MeshExtraction.h"

#include "AssemblyLine.h"
#include "CeilingSearch.h"
#include "FrontFinder.h"
#include "MeshJoiner.h"
#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/Powers.h>
#include <isofront/hierarchy/Refinement.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

namespace isofront::surface {

namespace {

using Clock = std::chrono::steady_clock;
using core::ErrorCode;
using hierarchy::CellId;
using hierarchy::CellIdHash;
using hierarchy::LatticePoint;
using hierarchy::LatticePointHash;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What could hardly be needed, or held: an eighth of what is foretold must be over the limit.
constexpr double kFarOver = 8;

/// An amount of memory as people read it.
std::string sizeText(double bytes)
{
    static constexpr std::array<const char*, 5> kUnits{"MiB", "GiB", "TiB", "PiB", "EiB"};
    std::size_t unit = 0;
    double amount = bytes / (1 << 20U);
    for (; amount >= 10240 && unit + 1 < kUnits.size(); ++unit)
        amount /= 1024;
    if (amount >= 10240)
        return "more than 10000 EiB";
    return std::to_string(static_cast<std::int64_t>(std::ceil(amount))) + " " + kUnits[unit];
}

/// The front of one extraction, and the meshes of its cells.
class Extraction {
public:
    /// @param coarser  steps of `Ceiling` by which it is to be coarser than asked for
    Extraction(
        std::shared_ptr<const extractor::CellExtractor> extractor,
        core::Jobs& jobs,
        const MeshExtractionOptions& options,
        const Detail& detail,
        double coarser)
        : _extractor(std::move(extractor)), _jobs(jobs), _options(options), _detail(detail),
          _finder(*_extractor, jobs, options.stop)
    {
        _result.detail = detail;
        _result.coarser = coarser;
    }

    core::Result<ExtractedMesh> run()
    {
        std::optional<core::Error> error;
        if (_detail.kind == Detail::Kind::level)
            error = refineToLevel(_detail.level);
        else if (_detail.kind == Detail::Kind::view)
            error = refineForView();
        else
            error = refineByError();
        if (!error)
            error = joinCells();
        if (error)
            return tl::unexpected<core::Error>(*error);
        return std::move(_result);
    }

    /// How many triangles there would be, about, if the work was ended because they are too many.
    [[nodiscard]] std::optional<double> tooManyTriangles() const { return _tooMany; }

private:
    using MaybeError = std::optional<core::Error>;

    [[nodiscard]] MaybeError interrupted() const
    {
        if (!_options.stop.stop_requested())
            return std::nullopt;
        return core::Error{ErrorCode::interrupted, "interrupted; nothing was written"};
    }

    [[nodiscard]] MaybeError overLimit(double bytes, const char* what) const
    {
        if (bytes <= static_cast<double>(_options.memoryLimit))
            return std::nullopt;
        return core::Error{
            ErrorCode::resourceLimit,
            std::string(what) + " would need about " + sizeText(bytes) + ", over the limit of " +
                sizeText(static_cast<double>(_options.memoryLimit)) +
                ": choose a larger spacing or error, a lower level, or a higher --memory-limit"};
    }
    [[nodiscard]] MaybeError overLimit(std::size_t bytes, const char* what) const
    {
        return overLimit(static_cast<double>(bytes), what);
    }

    /// Remembers that there are too many triangles.
    /// @param total  that there would be
    MaybeError overCeiling(double total)
    {
        _tooMany = total;
        return core::Error{
            ErrorCode::resourceLimit,
            "the coarsest mesh of this surface has more than " +
                std::to_string(_options.maxTriangles) +
                " triangles: choose a higher --max-triangles"};
    }

    void progress(const char* what, double share) const
    {
        if (_options.progress)
            _options.progress(what, share);
    }

    /// Triangles of so many cells with a surface, by those of a plane through each.
    [[nodiscard]] double expectedTriangles(double cells) const
    {
        const double n = _extractor->settings().latticeSize;
        return cells * 5 * n * n;
    }
    /// What a mesh of so many triangles takes.
    static double expectedBytes(double triangles)
    {
        constexpr double kBytesPerTriangle = 60; // cell mesh, borders and joined mesh
        return triangles * kBytesPerTriangle;
    }

    /// As a viewer needs it.
    MaybeError refineForView()
    {
        const auto start = Clock::now();
        const hierarchy::Domain& domain = _extractor->domain();
        const hierarchy::View& view = _detail.view;
        const double stretch = domain.worldFromField.stretch();
        // the pixel error in `_detail` is coarser already
        const auto criterion = detailCriterion(
            _extractor,
            view.pixelsPerUnit(),
            _options.detail.pixelError,
            _detail.settings,
            nullptr,
            _result.coarser);
        const auto isWanted = [&](const hierarchy::Diamond& diamond) {
            return hierarchy::distanceTo(domain, stretch, diamond, view.eye) <
                   criterion->refineDistance(diamond);
        };
        const auto check = [&](std::size_t bytes, int) { return stillFinding(bytes, -1); };
        auto error =
            _finder.refine(_front, coarserLevel(_detail.level, _result.coarser), isWanted, check);
        _result.frontSeconds += secondsSince(start);
        return error;
    }

    /// One level wherever there may be a surface.
    MaybeError refineToLevel(int level)
    {
        const auto start = Clock::now();
        double share = 0;
        const auto check = [&](std::size_t bytes, int coarsest) -> MaybeError {
            // three levels make four times as many diamonds, and as much work
            share = std::max(share, core::twoToThirds(2 * (coarsest - level)));
            if (auto error = stillFinding(bytes, share))
                return error;
            return foretold(level, coarsest - 1);
        };
        auto error = _finder.refine(
            _front, level, [](const hierarchy::Diamond&) { return true; }, check);
        _result.frontSeconds += secondsSince(start);
        return error;
    }

    /// Refuses a level far beyond the limits before much work is done, by how the cells grow.
    /// @param counted  the last level of which all cells are known
    MaybeError foretold(int level, int counted)
    {
        const auto trianglesAt = [&](int which) -> std::optional<double> {
            const auto diamonds = _finder.growth().expectedAt(which, counted);
            if (!diamonds)
                return std::nullopt;
            // tetrahedra of a diamond, by class
            return expectedTriangles(
                *diamonds * std::array<double, 3>{6, 4, 8}[static_cast<std::size_t>(which % 3)]);
        };
        const auto triangles = trianglesAt(level);
        if (!triangles)
            return std::nullopt;
        if (_options.maxTriangles > 0 &&
            *triangles > kFarOver * static_cast<double>(_options.maxTriangles))
            return overCeiling(*triangles);
        const auto limit = static_cast<double>(_options.memoryLimit);
        if (expectedBytes(*triangles) <= kFarOver * limit)
            return std::nullopt;
        int fits = level;
        // what is named must do, and the estimate may be too low
        for (auto fewer = triangles; fewer && 2 * expectedBytes(*fewer) > limit; --fits)
            fewer = trianglesAt(fits - 1);
        return core::Error{
            ErrorCode::resourceLimit,
            "a mesh of level " + std::to_string(level) + " would need about " +
                sizeText(expectedBytes(*triangles)) +
                ", by how its cells grow in number down to level " + std::to_string(counted) +
                ", over the limit of " + sizeText(limit) + ": choose level " +
                std::to_string(fits) + " or a lower one, a spacing " +
                std::to_string(1 << std::min(30, (level - fits + 2) / 3)) +
                " times as large, or a higher --memory-limit"};
    }

    /// @param share  of the work that is done; below 0 if it can't be told
    [[nodiscard]] MaybeError stillFinding(std::size_t bytes, double share) const
    {
        progress("finding cells", share);
        if (auto error = overLimit(bytes, "finding the cells"))
            return error;
        return interrupted();
    }

    /// Calls `body(i)` for each i below `count` on all threads, `chunk` of them at a time, as long
    /// as nobody has asked to stop.
    template <typename Body>
    void inChunks(std::size_t count, std::size_t chunk, const Body& body)
    {
        _jobs.parallelFor((count + chunk - 1) / chunk, [&](std::size_t k) {
            if (_options.stop.stop_requested())
                return;
            for (std::size_t i = k * chunk; i < std::min(count, (k + 1) * chunk); ++i)
                body(i);
        });
    }

    /// Splits diamonds around cells whose estimated error is too large, until there are none.
    MaybeError refineByError()
    {
        // Coarse cells may miss what lies between their samples: begin with 64 steps of the domain.
        const int n = _extractor->settings().latticeSize;
        int first = 0;
        while (first < _detail.level && hierarchy::axisStep(first, n) > _result.coarser / 64)
            ++first;
        if (auto error = refineToLevel(first))
            return error;
        const double stretch = _extractor->domain().worldFromField.stretch();
        std::vector<CellId> wanted = cellsOf(frontDiamonds());
        while (!wanted.empty()) {
            if (auto error = keepCells(wanted))
                return error;
            const auto start = Clock::now();
            std::vector<LatticePoint> tooCoarse;
            for (const auto& [id, cell] : _kept) {
                const bool canSplit = hierarchy::Diamond(id.spine).level < _detail.level;
                const double error = double(cell.mesh.stats.errorMax) * stretch;
                if (canSplit && error > _detail.maxError)
                    tooCoarse.push_back(id.spine);
            }
            std::ranges::sort(tooCoarse);
            for (const LatticePoint& centre : tooCoarse)
                _front.refine(centre);
            std::erase_if(_kept, [&](const auto& entry) {
                if (_front.hasCell(entry.first))
                    return false;
                _keptBytes -= bytesOf(entry.second);
                _keptTriangles -= entry.second.mesh.triangleCount();
                return true;
            });
            wanted = cellsOf(frontDiamonds());
            std::erase_if(wanted, [&](const CellId& id) { return _kept.contains(id); });
            _result.frontSeconds += secondsSince(start);
        }
        return std::nullopt;
    }

    /// The diamonds that have cells, in order.
    [[nodiscard]] std::vector<hierarchy::FrontDiamond> frontDiamonds() const
    {
        std::vector<hierarchy::FrontDiamond> diamonds = _front.diamondsWithCells();
        std::ranges::sort(diamonds, {}, &hierarchy::FrontDiamond::centre);
        return diamonds;
    }

    static std::vector<CellId> cellsOf(const std::vector<hierarchy::FrontDiamond>& diamonds)
    {
        std::vector<CellId> ids;
        for (const hierarchy::FrontDiamond& diamond : diamonds)
            for (unsigned bits = diamond.cells; bits != 0; bits &= bits - 1)
                ids.push_back({diamond.centre, static_cast<std::uint8_t>(std::countr_zero(bits))});
        return ids;
    }

    /// Extracts cells that may have to give way to finer ones.
    MaybeError keepCells(const std::vector<CellId>& ids)
    {
        for (std::size_t begin = 0; begin < ids.size(); begin += kBlock) {
            progress("extracting cells", double(begin) / double(ids.size()));
            const std::size_t count = std::min(kBlock, ids.size() - begin);
            std::vector<JoinedCell> block(count);
            inChunks(count, kChunk, [&](std::size_t i) {
                block[i].id = ids[begin + i];
                extract(block[i]);
            });
            for (JoinedCell& cell : block) {
                _keptBytes += bytesOf(cell);
                _keptTriangles += cell.mesh.triangleCount();
                takeTimes(cell.trace);
                _kept.emplace(cell.id, std::move(cell));
            }
            // finer cells will only make them more
            if (_options.maxTriangles > 0 && _keptTriangles > _options.maxTriangles)
                return overCeiling(static_cast<double>(_keptTriangles));
            if (auto error = overLimit(_keptBytes, "the meshes of the cells"))
                return error;
            if (auto error = interrupted())
                return error;
        }
        return std::nullopt;
    }

    /// Adds a cell's times to the result's, once.
    void takeTimes(extractor::CellTrace& trace)
    {
        for (const auto& [from, to] :
             {std::pair{&trace.sampleSeconds, &_result.sampleSeconds},
              std::pair{&trace.contourSeconds, &_result.contourSeconds},
              std::pair{&trace.smoothSeconds, &_result.smoothSeconds},
              std::pair{&trace.simplifySeconds, &_result.simplifySeconds},
              std::pair{&trace.normalSeconds, &_result.normalSeconds}})
            *to += std::exchange(*from, 0.0);
    }

    void extract(JoinedCell& cell) const
    {
        cell.trace.borders.clear();
        _extractor->extractInto(hierarchy::tetrahedronOf(cell.id), cell.mesh, &cell.trace);
    }

    static std::size_t bytesOf(const JoinedCell& cell)
    {
        return cell.mesh.bytes() + cell.trace.borders.size() * sizeof(extractor::BorderVertex);
    }

    /// The cells that may have a triangle, in order. Counts the others.
    std::vector<CellId> cellsToJoin()
    {
        std::vector<hierarchy::FrontDiamond> diamonds = frontDiamonds();
        for (const hierarchy::FrontDiamond& diamond : diamonds)
            _result.finestLevel =
                std::max(_result.finestLevel, hierarchy::Diamond(diamond.centre).level);
        _result.cells = _front.cellCount();
        if (_extractor->settings().skipEmptyCells) {
            std::vector<LatticePoint> centres(diamonds.size());
            std::ranges::transform(
                diamonds, centres.begin(), [](const auto& diamond) { return diamond.centre; });
            const std::vector<std::uint8_t> empty = _finder.provedEmpty(centres);
            std::size_t i = 0;
            std::erase_if(diamonds, [&](const auto&) { return empty[i++] != 0; });
        }
        std::vector<CellId> ids = cellsOf(diamonds);
        _result.cellsSkipped = _result.cells - ids.size();
        return ids;
    }

    /// Extracts all cells of the front and joins them.
    MaybeError joinCells()
    {
        auto start = Clock::now();
        const std::vector<CellId> ids = cellsToJoin();
        _result.frontSeconds += secondsSince(start);
        if (auto error = interrupted())
            return error;
        const double expected = expectedTriangles(static_cast<double>(ids.size()));
        const auto most = static_cast<double>(_options.maxTriangles);
        if (_options.maxTriangles > 0 && expected > kFarOver * most)
            return overCeiling(expected);
        if (auto error = overLimit(
                expectedBytes(_options.maxTriangles > 0 ? std::min(expected, most) : expected),
                "extracting the mesh"))
            return error;

        const int n = _extractor->settings().latticeSize;
        const bool hasAttributes =
            _extractor->settings().attributes && _extractor->field().hasAttributes();
        MeshJoiner joiner(_extractor->domain(), n, _result.finestLevel, hasAttributes);
        // what is beyond the ceiling is noticed within some chunks of cells
        joiner.reserve(
            _result.mesh,
            ids.size(),
            _options.maxTriangles > 0 ? _options.maxTriangles + _options.maxTriangles / 8
                                      : std::numeric_limits<std::size_t>::max());
        AssemblySteps steps;
        steps.extract = [&](std::size_t i, JoinedCell& cell) { take(ids[i], cell); };
        steps.count = [&](JoinedCell& cell) { count(cell); };
        steps.check = [&](std::size_t done, std::size_t bytes) -> MaybeError {
            const std::size_t triangles = joiner.indexCount() / 3;
            if (_options.maxTriangles > 0 && triangles > _options.maxTriangles)
                return overCeiling(
                    static_cast<double>(triangles) * static_cast<double>(ids.size()) /
                    static_cast<double>(done));
            const MaybeError error = overLimit(bytes + _keptBytes, "the mesh");
            return error ? error : interrupted();
        };
        steps.progress = [&](std::size_t done) {
            progress("extracting cells", double(done) / double(ids.size()));
        };
        const Assembled assembled = assemble(ids.size(), n, _jobs, steps, joiner, _result.mesh);
        _result.joinSeconds += assembled.seconds;
        if (assembled.error)
            return assembled.error;
        if (!_result.mesh.indices.empty())
            _result.errorRms =
                std::sqrt(_squaredError / (static_cast<double>(_result.mesh.indices.size()) / 3));
        progress("extracting cells", 1.0);
        return std::nullopt;
    }

    /// The mesh of a cell: one that was kept, or a new one.
    void take(const CellId& id, JoinedCell& cell)
    {
        cell.id = id;
        if (const auto kept = _kept.find(id); kept != _kept.end())
            cell = std::move(kept->second);
        else
            extract(cell);
    }

    /// Sums what a cell tells.
    void count(JoinedCell& cell)
    {
        const double stretch = _extractor->domain().worldFromField.stretch();
        const extractor::CellStats& stats = cell.mesh.stats;
        _result.cellsSkipped += stats.provedEmpty ? 1U : 0U;
        _result.samples += stats.samples;
        _result.sanitisedSamples += stats.sanitisedSamples;
        takeTimes(cell.trace);
        const double rms = double(stats.errorRms) * stretch;
        _squaredError += rms * rms * static_cast<double>(cell.mesh.triangleCount());
        _result.errorMax = std::max(_result.errorMax, double(stats.errorMax) * stretch);
    }

    /// Cells that are extracted between two looks at the limits, and in one job.
    static constexpr std::size_t kBlock = 2048;
    static constexpr std::size_t kChunk = 16;

    std::shared_ptr<const extractor::CellExtractor> _extractor;
    core::Jobs& _jobs;
    const MeshExtractionOptions& _options;
    Detail _detail;
    FrontFinder _finder;
    std::optional<double> _tooMany;
    hierarchy::Front _front;
    /// Cells of the front whose meshes are there already, for Detail::Kind::error.
    std::unordered_map<CellId, JoinedCell, CellIdHash> _kept;
    std::size_t _keptBytes = 0;
    std::size_t _keptTriangles = 0;
    double _squaredError = 0; ///< summed over triangles
    ExtractedMesh _result;
};

/// The ways to be coarser than asked for, step by step.
struct Ceiling {
    /// What is left of the triangles of a surface by each step, about.
    double perStep = 1;
    int lastStep = 0;

    explicit Ceiling(const Detail& detail)
    {
        if (detail.kind == Detail::Kind::level) {
            perStep = core::twoToThirds(-2);
            lastStep = detail.level;
        } else {
            perStep = core::twoToEighths(-2);
            lastStep = 320; // a factor of 2^40, beyond which there is nothing left to save
        }
    }
    static double factorOf(Detail::Kind kind, int step)
    {
        return kind == Detail::Kind::level ? core::twoToThirds(step) : core::twoToEighths(step);
    }
    static Detail coarser(Detail detail, int step)
    {
        const double factor = factorOf(detail.kind, step);
        if (detail.kind == Detail::Kind::level)
            detail.level -= step;
        else if (detail.kind == Detail::Kind::error)
            detail.maxError *= factor;
        else
            detail.pixelError *= factor;
        return detail;
    }
};

} // namespace

core::Result<ExtractedMesh> extractMesh(
    std::shared_ptr<const extractor::CellExtractor> extractor,
    core::Jobs& jobs,
    const MeshExtractionOptions& options)
{
    const Detail& asked = options.detail;
    if (asked.kind == Detail::Kind::view && !asked.view.isValid())
        return core::failure(ErrorCode::usage, "the view to extract for is not valid");
    const Ceiling ceiling(asked);
    CeilingSearch search(
        static_cast<double>(std::max<std::size_t>(1, options.maxTriangles)),
        ceiling.perStep,
        options.maxTriangles > 0 ? ceiling.lastStep : 0);
    std::optional<ExtractedMesh> best;
    std::optional<core::Error> lastError;
    while (const auto step = search.next()) {
        Extraction extraction(
            extractor,
            jobs,
            options,
            Ceiling::coarser(asked, *step),
            Ceiling::factorOf(asked.kind, *step));
        auto result = extraction.run();
        if (!result && !extraction.tooManyTriangles())
            return result;
        if (result) {
            search.tell(static_cast<double>(result->mesh.indices.size()) / 3, true);
            best = std::move(*result);
        } else {
            search.tell(*extraction.tooManyTriangles(), false);
            lastError = result.error();
        }
    }
    if (!best)
        return tl::unexpected<core::Error>(*lastError);
    return std::move(*best);
}

} // namespace isofront::surface
