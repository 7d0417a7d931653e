#include "isofront/tiles/Tileset.h"

#include "Deviation.h"
#include "NewFolder.h"
#include "TileCutting.h"
#include "TileTree.h"

#include <isofront/exchange/MeshFile.h>
#include <isofront/exchange/OutputFile.h>
#include <isofront/hierarchy/Criterion.h>
#include <isofront/surface/MeshExtraction.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <system_error>

namespace isofront::tiles {

namespace {

using core::ErrorCode;

core::Result<void>
checkOptions(const TilesetOptions& options, const extractor::ExtractionSettings& settings)
{
    if (options.levels < 1 || options.levels > kMostLevels)
        return core::failure(
            ErrorCode::usage,
            "a tileset has 1 to " + std::to_string(kMostLevels) + " levels, not " +
                std::to_string(options.levels));
    const int least = 2 * settings.latticeSize;
    if (options.tileSteps < least || options.tileSteps > 1024 ||
        !std::has_single_bit(static_cast<unsigned>(options.tileSteps)))
        return core::failure(
            ErrorCode::usage,
            "tiles of " + std::to_string(options.tileSteps) +
                " steps: it must be a power of two from " + std::to_string(least) + " to 1024");
    if (!(options.maxError >= 0) || !std::isfinite(options.maxError))
        return core::failure(
            ErrorCode::usage, "the error of a tileset must be a number of world units, 0 or more");
    return {};
}

/// One tileset in the making: from the finest level up, so that a tile knows what lies below it.
class TilesetWriter {
public:
    TilesetWriter(
        std::shared_ptr<const fields::Field> field,
        const hierarchy::Domain& domain,
        const extractor::ExtractionSettings& settings,
        core::Jobs& jobs,
        const TilesetOptions& options,
        std::filesystem::path folder)
        : _field(std::move(field)), _domain(domain), _settings(settings), _jobs(jobs),
          _options(options), _folder(std::move(folder)), _tree(0)
    {
    }

    core::Result<TilesetReport> run()
    {
        auto finest = extractFinest();
        if (!finest)
            return tl::unexpected<core::Error>(finest.error());
        for (int depth = _deepest; depth >= 0; --depth) {
            core::Result<surface::TriangleMesh> mesh =
                depth == _deepest ? std::move(*finest) : extract(depth);
            if (!mesh)
                return tl::unexpected<core::Error>(mesh.error());
            if (const auto written = writeLevel(depth, *mesh); !written)
                return tl::unexpected<core::Error>(written.error());
        }
        _tree.finish();
        return describe();
    }

private:
    [[nodiscard]] int levelOf(int depth) const
    {
        // cells of level 3k fill cubes of which 2^k lie along the domain, 2n steps each
        const int cellsOfTile = _options.tileSteps / (2 * _settings.latticeSize);
        return 3 * (depth + std::countr_zero(static_cast<unsigned>(cellsOfTile)));
    }
    /// Lattice step [field].
    [[nodiscard]] double stepAt(int depth) const
    {
        return std::ldexp(_domain.edge / _options.tileSteps, -depth);
    }
    [[nodiscard]] double worldStepAt(int depth) const
    {
        return stepAt(depth) * _domain.worldFromField.stretch();
    }

    [[nodiscard]] core::Result<surface::ExtractedMesh>
    extractWith(int depth, bool isFinest, std::size_t maxTriangles) const
    {
        extractor::ExtractionSettings settings = _settings;
        settings.attributes = false;
        settings.estimateError = false;
        settings.cornerRadius =
            2 * hierarchy::axisStep(levelOf(depth), settings.latticeSize) * _domain.edge;
        if (!isFinest)
            settings.filterStrength = _options.coarseFilter;
        surface::MeshExtractionOptions options;
        options.detail.level = levelOf(depth);
        options.memoryLimit = _options.memoryLimit;
        options.maxTriangles = maxTriangles;
        options.stop = _options.stop;
        if (_options.progress)
            options.progress = [&](const char* what, double share) {
                _options.progress("level " + std::to_string(depth) + ": " + what, share);
            };
        return surface::extractMesh(
            std::make_shared<const extractor::CellExtractor>(_field, _domain, settings),
            _jobs,
            options);
    }

    core::Result<surface::TriangleMesh> extract(int depth)
    {
        auto made = extractWith(depth, depth == _deepest, 0);
        if (!made)
            return tl::unexpected<core::Error>(made.error());
        _report.sanitisedSamples += made->sanitisedSamples;
        return std::move(made->mesh);
    }

    /// The finest level that the ceiling allows. Says which it is.
    core::Result<surface::TriangleMesh> extractFinest()
    {
        _deepest = _options.levels - 1;
        for (;;) {
            auto made = extractWith(_deepest, true, _options.maxTriangles);
            if (!made)
                return tl::unexpected<core::Error>(made.error());
            if (made->detail.level == levelOf(_deepest)) {
                _report.sanitisedSamples += made->sanitisedSamples;
                _tree = TileTree(_deepest + 1);
                return std::move(made->mesh);
            }
            // levels between those that fill cubes don't help
            const int fits = (made->detail.level - levelOf(0)) / 3;
            if (made->detail.level < levelOf(0))
                return core::failure(
                    ErrorCode::resourceLimit,
                    "a single tile of this surface has more than " +
                        std::to_string(_options.maxTriangles) +
                        " triangles: choose a higher --max-triangles, or smaller tiles");
            _deepest = std::min(_deepest - 1, fits);
        }
    }

    core::Result<void> writeLevel(int depth, const surface::TriangleMesh& mesh)
    {
        if (_options.progress)
            _options.progress("level " + std::to_string(depth) + ": cutting tiles", -1);
        // as far as the tiles of the next coarser level may be off, and more
        const double margin = 1.0 / _options.tileSteps;
        const std::vector<TilePart> parts = withParents(
            depth,
            mesh.indices.empty() ? std::vector<TilePart>()
                                 : cutIntoTiles(mesh, _domain, depth, margin));

        std::error_code failed;
        std::filesystem::create_directory(_folder / std::to_string(depth), failed);
        if (failed)
            return core::failure(
                ErrorCode::inputOutput,
                _folder.string() + ": no folder can be made in it (" + failed.message() + ")");
        std::vector<Tile> tiles(parts.size());
        std::vector<std::optional<core::Error>> errors(parts.size());
        for (std::size_t begin = 0; begin < parts.size(); begin += kBlock) {
            if (_options.progress)
                _options.progress(
                    "level " + std::to_string(depth) + ": writing tiles",
                    double(begin) / double(parts.size()));
            _jobs.parallelFor(std::min(kBlock, parts.size() - begin), [&](std::size_t i) {
                if (!_options.stop.stop_requested())
                    errors[begin + i] = writeTile(mesh, parts[begin + i], tiles[begin + i]);
            });
            if (_options.stop.stop_requested())
                return core::failure(ErrorCode::interrupted, "interrupted; nothing was written");
            for (const auto& error : errors)
                if (error)
                    return tl::unexpected<core::Error>(*error);
        }

        _tree.setLevel(depth, std::move(tiles), worldStepAt(depth));
        if (_options.maxError > 0 && depth < _deepest)
            for (const TileId& tile : _tree.dropBelow(depth, _options.maxError, worldStepAt(depth)))
                std::filesystem::remove(_folder / TileTree::fileName(tile), failed);
        return {};
    }

    /// The parts that become tiles: those that have a triangle of their own, or lie above others.
    [[nodiscard]] std::vector<TilePart> withParents(int depth, std::vector<TilePart> parts) const
    {
        if (depth == _deepest) {
            std::erase_if(parts, [](const TilePart& part) { return part.home.empty(); });
            return parts;
        }
        const std::vector<std::uint64_t> parents = _tree.parentsAt(depth);
        const auto keyOf = [](const TilePart& part) { return part.tile.key(); };
        std::erase_if(parts, [&](const TilePart& part) {
            return part.home.empty() && !std::ranges::binary_search(parents, part.tile.key());
        });
        const std::size_t count = parts.size();
        for (const std::uint64_t key : parents) {
            const auto end = parts.begin() + static_cast<std::ptrdiff_t>(count);
            const auto found = std::ranges::lower_bound(parts.begin(), end, key, {}, keyOf);
            if (found == end || keyOf(*found) != key) {
                parts.emplace_back();
                parts.back().tile = TileId::ofKey(depth, key);
            }
        }
        std::ranges::sort(parts, {}, keyOf);
        return parts;
    }

    [[nodiscard]] std::optional<core::Error>
    writeTile(const surface::TriangleMesh& mesh, const TilePart& part, Tile& tile) const
    {
        const int depth = part.tile.depth;
        tile.id = part.tile;
        tile.octants = part.octants;
        tile.triangles = part.home.size() + part.rim.size();
        tile.measuredError =
            part.home.empty()
                ? worldStepAt(depth)
                : largestDeviation(
                      *_field, _domain, _settings.isovalue, mesh, part.home, stepAt(depth));
        if (tile.triangles == 0)
            return std::nullopt;
        exchange::ExportOptions options;
        options.name = _options.name;
        const auto written = exchange::writeMesh(
            tileMesh(mesh, part, tile.content), _folder / TileTree::fileName(part.tile), options);
        if (!written)
            return written.error();
        tile.bytes = written->bytes;
        return std::nullopt;
    }

    core::Result<TilesetReport> describe()
    {
        _report.levelsAskedFor = _options.levels;
        for (int depth = 0; depth <= _deepest; ++depth) {
            TilesetLevel level;
            level.step = worldStepAt(depth);
            for (const Tile& tile : _tree.level(depth)) {
                if (tile.isDropped)
                    continue;
                level.tiles += tile.hasFile() ? 1U : 0U;
                level.triangles += tile.triangles;
                level.error = std::max(level.error, tile.error);
                level.measuredError = std::max(level.measuredError, tile.measuredError);
                _report.bytes += tile.bytes;
                _report.bounds.low = glm::min(_report.bounds.low, tile.box.low);
                _report.bounds.high = glm::max(_report.bounds.high, tile.box.high);
            }
            _report.files += level.tiles;
            _report.levels.push_back(level);
        }
        // nothing is left of levels that weren't needed
        std::error_code ignored;
        for (; _report.levels.size() > 1 && _report.levels.back().tiles == 0;
             _report.levels.pop_back())
            std::filesystem::remove(_folder / std::to_string(_report.levels.size() - 1), ignored);
        if (_report.files == 0)
            _report.warnings.emplace_back("the surface is empty, so the tileset holds no "
                                          "triangles; check the isovalue and the bounds");

        core::Box whole;
        const core::Box cube = _domain.fieldBox();
        for (unsigned corner = 0; corner < 8; ++corner)
            whole.include(_domain.worldFromField.point(
                {(corner & 1U) != 0 ? cube.high.x : cube.low.x,
                 (corner & 2U) != 0 ? cube.high.y : cube.low.y,
                 (corner & 4U) != 0 ? cube.high.z : cube.low.z}));
        nlohmann::ordered_json json = _tree.json(whole);
        json["asset"]["generator"] = "Isofront";
        for (const auto& [key, value] : _options.settings)
            json["asset"]["extras"][key] = value;
        const auto written = exchange::writeFile(
            _folder / "tileset.json",
            json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
        if (!written)
            return tl::unexpected<core::Error>(written.error());
        _report.bytes += *written;
        ++_report.files;
        return std::move(_report);
    }

    /// Tiles that are written between two looks at the user's wishes.
    static constexpr std::size_t kBlock = 64;

    std::shared_ptr<const fields::Field> _field;
    const hierarchy::Domain& _domain;
    const extractor::ExtractionSettings& _settings;
    core::Jobs& _jobs;
    const TilesetOptions& _options;
    std::filesystem::path _folder;
    int _deepest = 0;
    TileTree _tree;
    TilesetReport _report;
};

} // namespace

core::Result<TilesetReport> writeTileset(
    std::shared_ptr<const fields::Field> field,
    const hierarchy::Domain& domain,
    const extractor::ExtractionSettings& settings,
    core::Jobs& jobs,
    const TilesetOptions& options,
    const std::filesystem::path& folder)
{
    if (const auto checked = checkOptions(options, settings); !checked)
        return tl::unexpected<core::Error>(checked.error());
    auto made = NewFolder::create(folder);
    if (!made)
        return tl::unexpected<core::Error>(made.error());
    auto report =
        TilesetWriter(std::move(field), domain, settings, jobs, options, made->path()).run();
    if (!report)
        return report;
    if (const auto committed = made->commit(); !committed)
        return tl::unexpected<core::Error>(committed.error());
    return report;
}

} // namespace isofront::tiles
