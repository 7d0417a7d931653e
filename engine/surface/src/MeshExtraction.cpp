#include "isofront/surface/MeshExtraction.h"

#include "isofront/surface/SurfaceCriterion.h"

#include <isofront/core/Hash.h>
#include <isofront/hierarchy/Refinement.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
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
using extractor::CellMesh;
using extractor::CellTrace;
using hierarchy::CellId;
using hierarchy::CellIdHash;
using hierarchy::LatticePoint;
using hierarchy::LatticePointHash;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

struct ExtractedCell {
    CellId id;
    CellMesh mesh;
    CellTrace trace;
};

std::size_t bytesOf(const ExtractedCell& cell)
{
    return cell.mesh.bytes() + cell.trace.borders.size() * sizeof(extractor::BorderVertex);
}

struct KeyHash {
    std::size_t operator()(const std::array<std::int64_t, 3>& key) const
    {
        std::uint64_t hash = 0;
        for (const std::int64_t word : key)
            hash = core::hashCombined(hash, static_cast<std::uint64_t>(word));
        return hash;
    }
};

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
            error = refine(levelCriterion(_extractor, detail.level), {}, detail.level);
        else if (detail.kind == Detail::Kind::view)
            error = refine(
                viewCriterion(_extractor, detail.view.pixelsPerUnit(), detail.pixelError),
                detail.view,
                detail.level);
        else
            error = refineByError();
        if (!error && detail.kind != Detail::Kind::error)
            error = extractCells(cellsOf(*_front));
        if (error)
            return tl::unexpected<core::Error>(*error);
        return join();
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

    MaybeError
    refine(std::shared_ptr<const WhereSurface> criterion, const hierarchy::View& view, int maxLevel)
    {
        _where = criterion;
        const auto start = Clock::now();
        hierarchy::Refinement refinement(
            _extractor->domain(), std::move(criterion), {.maxLevel = maxLevel});
        do {
            refinement.update(view);
            progress("finding cells", 0.0);
            if (auto error = overLimit(refinement.bytes() + _where->bytes(), "finding the cells"))
                return error;
            if (auto error = interrupted())
                return error;
        } while (!refinement.isSettled());
        _front = refinement.front();
        _frontSeconds += secondsSince(start);
        return std::nullopt;
    }

    /// Splits diamonds around cells whose estimated error is too large, until there are none.
    MaybeError refineByError()
    {
        // Coarse cells may miss what lies between their samples: begin with 64 steps of the domain.
        const int n = _extractor->settings().latticeSize;
        int first = 0;
        while (first < _options.detail.level && hierarchy::axisStep(first, n) > 1.0 / 64)
            ++first;
        if (auto error = refine(levelCriterion(_extractor, first), {}, first))
            return error;
        const double stretch = _extractor->domain().worldFromField.stretch();
        auto wanted = cellsOf(*_front);
        while (!wanted.empty()) {
            if (auto error = extractCells(std::move(wanted)))
                return error;
            const auto start = Clock::now();
            std::vector<LatticePoint> tooCoarse;
            for (const auto& [id, cell] : _cells) {
                const bool canSplit = hierarchy::Diamond(id.spine).level < _options.detail.level;
                const double error = double(cell.mesh.stats.errorMax) * stretch;
                if (canSplit && error > _options.detail.maxError)
                    tooCoarse.push_back(id.spine);
            }
            std::ranges::sort(tooCoarse);
            for (const LatticePoint& centre : tooCoarse)
                _front->refine(centre);
            std::erase_if(_cells, [&](const auto& entry) {
                if (_front->hasCell(entry.first))
                    return false;
                _bytes -= bytesOf(entry.second);
                _result.cellsSkipped -= entry.second.mesh.stats.provedEmpty ? 1U : 0U;
                return true;
            });
            wanted = cellsOf(*_front);
            std::erase_if(wanted, [&](const CellId& id) { return _cells.contains(id); });
            _frontSeconds += secondsSince(start);
        }
        return std::nullopt;
    }

    static std::vector<CellId> cellsOf(const hierarchy::Front& front)
    {
        std::vector<CellId> ids;
        ids.reserve(front.cellCount());
        front.forEachCell(
            [&](const CellId& id, const hierarchy::Tetrahedron&) { ids.push_back(id); });
        std::ranges::sort(ids);
        return ids;
    }

    MaybeError extractCells(const std::vector<CellId>& ids)
    {
        // The diamonds that bounds could not prove empty are those with a surface, or nearly.
        std::size_t expected = 0;
        for (const CellId& id : ids)
            expected += _where->provesEmpty(hierarchy::Diamond(id.spine)) ? 0U : 1U;
        if (auto error = overLimit(expectedBytes(expected), "extracting the mesh"))
            return error;

        constexpr std::size_t kSlice = 1024;
        std::vector<ExtractedCell> slice;
        for (std::size_t begin = 0; begin < ids.size(); begin += kSlice) {
            if (auto error = interrupted())
                return error;
            progress("extracting cells", double(begin) / double(ids.size()));
            const std::size_t count = std::min(kSlice, ids.size() - begin);
            slice.clear();
            slice.resize(count);
            _jobs.parallelFor(count, [&](std::size_t i) {
                ExtractedCell& cell = slice[i];
                cell.id = ids[begin + i];
                cell.mesh = *_extractor->extract(hierarchy::tetrahedronOf(cell.id), &cell.trace);
            });
            for (ExtractedCell& cell : slice) {
                const extractor::CellStats& stats = cell.mesh.stats;
                _result.cellsSkipped += stats.provedEmpty ? 1U : 0U;
                _result.samples += stats.samples;
                _result.sanitisedSamples += stats.sanitisedSamples;
                _result.sampleSeconds += cell.trace.sampleSeconds;
                _result.contourSeconds += cell.trace.contourSeconds;
                _result.normalSeconds += cell.trace.normalSeconds;
                _bytes += bytesOf(cell);
                _cells.emplace(cell.id, std::move(cell));
            }
            if (auto error = overLimit(_bytes, "the meshes of the cells"))
                return error;
        }
        return std::nullopt;
    }

    core::Result<ExtractedMesh> join()
    {
        const auto start = Clock::now();
        const hierarchy::Domain& domain = _extractor->domain();
        const glm::dmat3 normalMatrix = domain.worldFromField.normalMatrix();
        const bool mirrors = domain.worldFromField.mirrors();
        const double stretch = domain.worldFromField.stretch();
        TriangleMesh& mesh = _result.mesh;

        std::size_t vertices = 0;
        std::size_t triangles = 0;
        for (const auto& [id, cell] : _cells) {
            vertices += cell.mesh.vertices.size();
            triangles += cell.mesh.triangleCount();
        }
        mesh.positions.reserve(vertices);
        mesh.normals.reserve(vertices);
        mesh.indices.reserve(3 * triangles);

        std::unordered_map<std::array<std::int64_t, 3>, std::uint32_t, KeyHash> shared;
        std::vector<std::uint32_t> global;
        constexpr std::uint32_t kUnset = std::numeric_limits<std::uint32_t>::max();
        double squared = 0;
        std::size_t done = 0;
        for (const CellId& id : cellsOf(*_front)) {
            const auto found = _cells.find(id);
            _result.finestLevel = std::max(_result.finestLevel, hierarchy::Diamond(id.spine).level);
            if (++done % 4096 == 0)
                progress("joining cells", double(done) / double(_cells.size()));
            const ExtractedCell& cell = found->second;
            const CellMesh& part = cell.mesh;
            if (part.indices.empty())
                continue;
            if (mesh.positions.size() + part.vertices.size() >= kUnset)
                return core::failure(
                    ErrorCode::resourceLimit,
                    "the mesh has more than 4294967294 vertices: choose a larger spacing or error");

            const auto place = [&](std::size_t i) {
                const extractor::CellVertex& vertex = part.vertices[i];
                const glm::dvec3 position = domain.worldFromGrid(part.gridPosition(vertex));
                const glm::dvec3 normal =
                    glm::normalize(normalMatrix * extractor::fromOctahedral(vertex.normal));
                mesh.positions.push_back(position);
                mesh.normals.emplace_back(normal);
                mesh.bounds.include(position);
                return static_cast<std::uint32_t>(mesh.positions.size() - 1);
            };
            global.assign(part.vertices.size(), kUnset);
            for (const extractor::BorderVertex& border : cell.trace.borders) {
                const auto [entry, isNew] = shared.try_emplace(border.key, kUnset);
                if (isNew)
                    entry->second = place(border.vertex);
                global[border.vertex] = entry->second;
            }
            for (std::size_t i = 0; i < global.size(); ++i)
                if (global[i] == kUnset)
                    global[i] = place(i);
            for (std::size_t i = 0; i < part.indices.size(); i += 3) {
                const std::size_t second = mirrors ? 2 : 1;
                for (const std::size_t k : {std::size_t{0}, second, 3 - second})
                    mesh.indices.push_back(global[part.indices[i + k]]);
            }
            const double rms = double(part.stats.errorRms) * stretch;
            squared += rms * rms * static_cast<double>(part.triangleCount());
            _result.errorMax = std::max(_result.errorMax, double(part.stats.errorMax) * stretch);
        }
        if (triangles > 0)
            _result.errorRms = std::sqrt(squared / static_cast<double>(triangles));
        _result.cells = _front->cellCount();
        _result.frontSeconds = _frontSeconds;
        _result.joinSeconds = secondsSince(start);
        progress("joining cells", 1.0);
        return std::move(_result);
    }

    std::shared_ptr<const extractor::CellExtractor> _extractor;
    core::Jobs& _jobs;
    const MeshExtractionOptions& _options;
    std::shared_ptr<const WhereSurface> _where; ///< the last criterion, for what it knows
    std::optional<hierarchy::Front> _front;
    std::unordered_map<CellId, ExtractedCell, CellIdHash> _cells;
    std::size_t _bytes = 0;
    double _frontSeconds = 0;
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
