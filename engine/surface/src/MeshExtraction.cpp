#include "isofront/surface/MeshExtraction.h"

#include "AssemblyLine.h"
#include "MeshJoiner.h"
#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/FlatMap.h>
#include <isofront/hierarchy/Refinement.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
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

/// The front of one extraction, and the meshes of its cells.
class Extraction {
public:
    Extraction(
        std::shared_ptr<const extractor::CellExtractor> extractor,
        core::Jobs& jobs,
        const MeshExtractionOptions& options)
        : _extractor(std::move(extractor)), _jobs(jobs), _options(options)
    {
    }

    core::Result<ExtractedMesh> run()
    {
        const Detail& detail = _options.detail;
        std::optional<core::Error> error;
        if (detail.kind == Detail::Kind::view && !detail.view.isValid())
            return core::failure(ErrorCode::usage, "the view to extract for is not valid");
        if (detail.kind == Detail::Kind::level)
            error = refineToLevel(detail.level);
        else if (detail.kind == Detail::Kind::view)
            error = refine(
                viewCriterion(
                    _extractor, detail.view.pixelsPerUnit(), detail.pixelError, detail.settings),
                detail.view,
                detail.level);
        else
            error = refineByError();
        if (!error)
            error = joinCells();
        if (error)
            return tl::unexpected<core::Error>(*error);
        return std::move(_result);
    }

private:
    using MaybeError = std::optional<core::Error>;

    [[nodiscard]] MaybeError interrupted() const
    {
        if (!_options.stop.stop_requested())
            return std::nullopt;
        return core::Error{ErrorCode::interrupted, "interrupted; nothing was written"};
    }

    [[nodiscard]] MaybeError overLimit(std::size_t bytes, const char* what) const
    {
        if (bytes <= _options.memoryLimit)
            return std::nullopt;
        const auto mebibytes = [](std::size_t b) { return std::to_string((b >> 20U) + 1); };
        return core::Error{
            ErrorCode::resourceLimit,
            std::string(what) + " would need about " + mebibytes(bytes) +
                " MiB, over the limit of " + mebibytes(_options.memoryLimit - 1) +
                " MiB: choose a larger spacing or error, a lower level, or a higher "
                "--memory-limit"};
    }

    void progress(const char* what, double share) const
    {
        if (_options.progress)
            _options.progress(what, share);
    }

    /// What a mesh of so many cells with a surface takes, by the triangles of a plane through each.
    [[nodiscard]] std::size_t expectedBytes(std::size_t cells) const
    {
        const auto n = static_cast<std::size_t>(_extractor->settings().latticeSize);
        constexpr std::size_t kBytesPerTriangle = 60; // cell mesh, borders and joined mesh
        return cells * 5 * n * n * kBytesPerTriangle;
    }

    /// Follows the viewer to the end.
    MaybeError
    refine(std::shared_ptr<const WhereSurface> criterion, const hierarchy::View& view, int maxLevel)
    {
        const auto start = Clock::now();
        hierarchy::Refinement refinement(_extractor->domain(), criterion, {.maxLevel = maxLevel});
        do {
            refinement.update(view);
            if (auto error = stillFinding(refinement.bytes() + criterion->bytes()))
                return error;
        } while (!refinement.isSettled());
        _front = refinement.front();
        _result.frontSeconds += secondsSince(start);
        return std::nullopt;
    }

    /// The same for one level wherever there may be a surface, wave after wave of diamonds, whose
    /// bounds are taken by all threads. The front doesn't depend on the order of splits.
    MaybeError refineToLevel(int level)
    {
        const auto start = Clock::now();
        core::FlatMap<LatticePoint, bool, LatticePointHash> known(hierarchy::kNoLatticePoint);
        std::vector<LatticePoint> wave{hierarchy::kRootDiamond};
        while (!wave.empty() && level > 0) {
            const std::vector<std::uint8_t> empty = provedEmpty(wave);
            std::vector<LatticePoint> next;
            for (std::size_t i = 0; i < wave.size(); ++i) {
                if (empty[i] != 0)
                    continue;
                for (const LatticePoint& split : _front.refine(wave[i]))
                    for (const LatticePoint& child :
                         hierarchy::childrenOf(hierarchy::Diamond(split)))
                        if (hierarchy::Diamond(child).level < level &&
                            known.tryEmplace(child, true).second)
                            next.push_back(child);
            }
            wave = std::move(next);
            if (auto error = stillFinding(_front.bytes() + known.bytes()))
                return error;
        }
        _result.frontSeconds += secondsSince(start);
        return std::nullopt;
    }

    [[nodiscard]] MaybeError stillFinding(std::size_t bytes) const
    {
        progress("finding cells", 0.0);
        if (auto error = overLimit(bytes, "finding the cells"))
            return error;
        return interrupted();
    }

    /// For each diamond, whether bounds prove that no triangle can arise in it.
    [[nodiscard]] std::vector<std::uint8_t> provedEmpty(const std::vector<LatticePoint>& diamonds)
    {
        std::vector<std::uint8_t> empty(diamonds.size());
        inChunks(diamonds.size(), 64, [&](std::size_t i) {
            const core::Box box = boxOf(hierarchy::Diamond(diamonds[i]), _extractor->domain());
            empty[i] = _extractor->provesEmpty(box) ? 1 : 0;
        });
        return empty;
    }

    /// Calls `body(i)` for each i below `count` on all threads, `chunk` of them at a time.
    template <typename Body>
    void inChunks(std::size_t count, std::size_t chunk, const Body& body)
    {
        _jobs.parallelFor((count + chunk - 1) / chunk, [&](std::size_t k) {
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
        while (first < _options.detail.level && hierarchy::axisStep(first, n) > 1.0 / 64)
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
                const bool canSplit = hierarchy::Diamond(id.spine).level < _options.detail.level;
                const double error = double(cell.mesh.stats.errorMax) * stretch;
                if (canSplit && error > _options.detail.maxError)
                    tooCoarse.push_back(id.spine);
            }
            std::ranges::sort(tooCoarse);
            for (const LatticePoint& centre : tooCoarse)
                _front.refine(centre);
            std::erase_if(_kept, [&](const auto& entry) {
                if (_front.hasCell(entry.first))
                    return false;
                _keptBytes -= bytesOf(entry.second);
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
                takeTimes(cell.trace);
                _kept.emplace(cell.id, std::move(cell));
            }
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
            const std::vector<std::uint8_t> empty = provedEmpty(centres);
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
        if (auto error = overLimit(expectedBytes(ids.size()), "extracting the mesh"))
            return error;

        const int n = _extractor->settings().latticeSize;
        const bool hasAttributes =
            _extractor->settings().attributes && _extractor->field().hasAttributes();
        MeshJoiner joiner(_extractor->domain(), n, _result.finestLevel, hasAttributes);
        joiner.reserve(_result.mesh, ids.size());
        AssemblySteps steps;
        steps.extract = [&](std::size_t i, JoinedCell& cell) { take(ids[i], cell); };
        steps.count = [&](JoinedCell& cell) { count(cell); };
        steps.check = [&](std::size_t, std::size_t bytes) {
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
    hierarchy::Front _front;
    /// Cells of the front whose meshes are there already, for Detail::Kind::error.
    std::unordered_map<CellId, JoinedCell, CellIdHash> _kept;
    std::size_t _keptBytes = 0;
    double _squaredError = 0; ///< summed over triangles
    ExtractedMesh _result;
};

} // namespace

core::Result<ExtractedMesh> extractMesh(
    std::shared_ptr<const extractor::CellExtractor> extractor,
    core::Jobs& jobs,
    const MeshExtractionOptions& options)
{
    return Extraction(std::move(extractor), jobs, options).run();
}

} // namespace isofront::surface
