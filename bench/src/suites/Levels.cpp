// At which distance levels of detail change, by pixels that a pattern node fills: figure 6 of
// Jablonski and Martyn, and their sections 4 to 6.

#include "Models.h"
#include "Suites.h"
#include "isofront/bench/Timing.h"

#include <isofront/hierarchy/View.h>
#include <isofront/voxels/LevelEvaluation.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

/// Narrow, so that voxels are many pixels large from outside the object.
constexpr double kFieldOfView = 0.25;

/// What a frame shows of an object at a level.
struct Seen {
    double approximate = 0; ///< fill of a pattern node in the middle of the object [px]
    double accurate = 0;    ///< of the voxel that is nearest in the picture [px]
    std::uint64_t pixels = 0;
    double seconds = 0; ///< processor time of the accurate one
};

/// An object that is looked at from different distances. Each of its levels is voxelised for
/// itself, down to a few voxels, because the levels of a store end at a chunk.
class Object {
public:
    static core::Result<Object> create(
        const Context& context,
        const voxels::TriangleModel& model,
        std::uint32_t resolution,
        std::uint32_t levels,
        int width)
    {
        Object object;
        object._box = boundsOf(model);
        object._view.verticalFieldOfView = kFieldOfView;
        object._view.width = width;
        object._view.height = width * 3 / 4;
        for (std::uint32_t level = 0; level < levels; ++level) {
            auto store = inMemory(context, "the object", model, resolution >> level);
            if (!store)
                return tl::unexpected(store.error());
            Level& made = object._levels.emplace_back();
            made.store = std::move(*store);
            const voxels::ChunkCut cut = voxels::cutOfLevel(*made.store, 0);
            std::uint64_t first = 0;
            for (const voxels::ChunkKey& key : cut) {
                made.first.emplace_back(key, first);
                first += (*made.store->get(key))->voxels.size();
            }
            std::ranges::sort(made.first);
            auto caster = voxels::VoxelRayCaster::create(*made.store, cut);
            if (!caster)
                return tl::unexpected(caster.error());
            made.caster = std::make_unique<voxels::VoxelRayCaster>(std::move(*caster));
        }
        return object;
    }

    [[nodiscard]] std::uint32_t coarsest() const
    {
        return static_cast<std::uint32_t>(_levels.size()) - 1;
    }
    [[nodiscard]] std::uint64_t voxels(std::uint32_t level) const
    {
        return _levels[level].store->model().voxels;
    }
    [[nodiscard]] double size() const { return glm::length(_box.size()); }
    [[nodiscard]] double edge(std::uint32_t level) const
    {
        return _levels[level].store->model().lattice.edge;
    }
    [[nodiscard]] double pixelsPerUnit() const { return _view.pixelsPerUnit(); }

    /// @param distance  of the eye from the middle [world]
    [[nodiscard]] core::Result<Seen>
    from(double distance, std::uint32_t level, core::Jobs& jobs) const
    {
        const glm::dvec3 back = glm::normalize(glm::dvec3(-0.3, -1, 0.35));
        const glm::dvec3 eye = _box.centre() + distance * back;
        Seen seen;
        seen.approximate = voxels::approximateFill(_box, edge(level), eye, pixelsPerUnit());
        std::optional<core::Error> failure;
        const Timing timing = timed(
            [&] {
                std::vector<std::uint64_t> picture;
                const auto hits = _levels[level].caster->cast(raysFrom(eye, -back), jobs);
                if (!hits) {
                    failure = hits.error();
                    return;
                }
                std::optional<voxels::VoxelHit> nearest;
                for (const auto& hit : *hits) {
                    if (!hit) {
                        picture.push_back(voxels::kNoPatternPixel);
                        continue;
                    }
                    if (!nearest || hit->distance < nearest->distance)
                        nearest = hit;
                    ++seen.pixels;
                    // positive floats are in the order of their bits
                    const auto depth =
                        std::bit_cast<std::uint32_t>(static_cast<float>(hit->distance));
                    picture.push_back(std::uint64_t{depth} << 32U | idOf(_levels[level], *hit));
                }
                if (const auto node = voxels::patternNode(picture)) {
                    const double pixels = edge(level) * pixelsPerUnit() / nearest->distance;
                    seen.accurate = voxels::fillOf(*node, pixels * pixels);
                }
            },
            1);
        if (failure)
            return tl::unexpected(*failure);
        seen.seconds = timing.least;
        return seen;
    }

private:
    Object() = default;

    struct Level {
        std::shared_ptr<voxels::ChunkStore> store;
        std::unique_ptr<voxels::VoxelRayCaster> caster; ///< of the store
        std::vector<std::pair<voxels::ChunkKey, std::uint64_t>>
            first; ///< id of a chunk's first voxel
    };
    static std::uint32_t idOf(const Level& level, const voxels::VoxelHit& hit)
    {
        const auto found = std::ranges::lower_bound(
            level.first, hit.chunk, {}, &std::pair<voxels::ChunkKey, std::uint64_t>::first);
        return static_cast<std::uint32_t>(found->second + hit.index);
    }
    [[nodiscard]] std::vector<voxels::Ray>
    raysFrom(const glm::dvec3& eye, const glm::dvec3& ahead) const
    {
        const glm::dvec3 right = glm::normalize(glm::cross(ahead, _view.up));
        const glm::dvec3 above = glm::cross(right, ahead);
        const double step = 1 / pixelsPerUnit();
        std::vector<voxels::Ray> rays;
        for (int y = 0; y < _view.height; ++y)
            for (int x = 0; x < _view.width; ++x)
                rays.push_back(
                    {.start = eye,
                     .direction = ahead + step * (x + 0.5 - 0.5 * _view.width) * right -
                                  step * (y + 0.5 - 0.5 * _view.height) * above});
        return rays;
    }

    core::Box _box;
    hierarchy::View _view;
    std::vector<Level> _levels;
};

enum class Way { approximate, accurate };

const char* nameOf(Way way)
{
    return way == Way::approximate ? "middle of the object" : "nearest voxel of the picture";
}

Table levelTable()
{
    Table table{
        "levels",
        "The level shown, going away and coming back",
        {{"pattern",
          "",
          "node by whose pixels the level is decided: it gets coarser below 1 px, or 2 px of the "
          "nearest"},
         {"direction", "", "away or back"},
         {"distance", "sizes", "from the eye to the middle of the object, in its sizes"},
         {"shown", "", "level, 0 the finest; between two of them, on the way"},
         {"fill", "px", "of the pattern node of the level decided on"},
         {"ratio", "", "fill of the nearest voxel over that of one in the middle"},
         {"voxels", "", "of the level"},
         {"pixels", "", "that the object covers"},
         {"evaluation", "ms", "processor time of finding the nearest voxel, by rays"}},
        {},
        {}};
    Plot plot;
    plot.name = "away-and-back";
    plot.title = "Level by distance";
    plot.x = "distance";
    plot.y = "shown";
    plot.series = "direction";
    plot.whereColumn = "pattern";
    plot.isLogarithmicX = true;
    for (const Way way : {Way::approximate, Way::accurate}) {
        plot.whereWord = nameOf(way);
        plot.name = way == Way::approximate ? "level-middle" : "level-nearest";
        plot.title = std::string("Level by distance, pattern node: ") + nameOf(way);
        table.plots.push_back(plot);
    }
    return table;
}

/// Where the level decided on changes.
struct Change {
    double distance = 0; ///< [sizes]
    std::uint32_t to = 0;
};

} // namespace

SuiteResult runLevels(const Context& context)
{
    SuiteResult result;
    Table table = levelTable();
    const auto fail = [&](const core::Error& error) {
        if (!context.isStopped())
            result.check("levels are decided on", false, error.message);
        return result;
    };
    const auto made = Object::create(
        context,
        hills(context.pick(40U, 200U)),
        context.pick(128U, 512U),
        context.pick(4U, 6U),
        context.pick(160, 640));
    if (!made)
        return fail(made.error());
    const Object& object = *made;
    const int steps = context.pick(4, 6); // for each doubling of the distance
    const double nearest = 0.7;           // [sizes]
    const int doublings = context.pick(5, 7);
    constexpr int kFrames = 120; // at each distance, so that the level comes to rest

    for (const Way way : {Way::approximate, Way::accurate}) {
        voxels::LevelControlSettings settings;
        // a voxel that is seen has one pixel at least, so fewer must be known by another number
        settings.rates.least = way == Way::approximate ? 1 : 2;
        auto control = voxels::LevelControl::create(settings, object.coarsest(), 0);
        if (!control)
            return fail(control.error());
        std::vector<Change> away;
        std::vector<Change> back;
        std::size_t restless = 0;
        for (const bool isBack : {false, true}) {
            voxels::ShownLevel before = control->shown();
            for (int i = 0; i <= steps * doublings; ++i) {
                if (context.isStopped())
                    return result;
                const int at = isBack ? steps * doublings - i : i;
                const double distance = nearest * std::exp2(static_cast<double>(at) / steps);
                context.say(std::string(nameOf(way)) + ", " + textOf(distance) + " sizes away");
                Seen seen;
                std::optional<std::uint32_t> looked;
                double last = -1;
                std::uint32_t level = control->shown().level;
                for (int frame = 0; frame < kFrames; ++frame) {
                    level = control->shown().level;
                    if (looked != level) {
                        const auto now =
                            object.from(distance * object.size(), level, *context.jobs);
                        if (!now)
                            return fail(now.error());
                        seen = *now;
                        looked = level;
                    }
                    last = control->shown().number();
                    (void)control->update(
                        {.fill = way == Way::approximate ? seen.approximate : seen.accurate,
                         .level = level,
                         .pixels = seen.pixels,
                         .voxels = object.voxels(level)});
                }
                const voxels::ShownLevel shown = control->shown();
                restless += shown.number() == last ? 0U : 1U;
                if (shown.level > before.level)
                    away.push_back({distance, shown.level});
                if (shown.level < before.level)
                    back.push_back({distance, before.level});
                before = shown;
                table.add(
                    {std::string(nameOf(way)),
                     std::string(isBack ? "back" : "away"),
                     distance,
                     shown.number(),
                     way == Way::approximate ? seen.approximate : seen.accurate,
                     seen.accurate / seen.approximate,
                     count(object.voxels(shown.level)),
                     count(seen.pixels),
                     1e3 * seen.seconds});
            }
        }
        result.check(
            std::string(nameOf(way)) + ": at rest, the level rests",
            restless == 0,
            std::to_string(restless) + " distances at which it didn't");
        bool areApart = away.size() > 1;
        std::string where;
        for (std::size_t i = 0; i < away.size(); ++i) {
            where += (i > 0 ? ", " : "") + textOf(away[i].distance);
            if (i > 0) {
                const double ratio = away[i].distance / away[i - 1].distance;
                areApart = areApart && std::abs(std::log2(ratio) - 1) <= 1.01 / steps;
            }
        }
        if (way == Way::approximate) // the nearest voxel comes nearer by jumps
            result.check(
                std::string(nameOf(way)) + ": levels get coarser at doubled distances",
                areApart,
                where + " sizes");
        const bool hasHysteresis = std::ranges::all_of(back, [&](const Change& change) {
            return std::ranges::all_of(away, [&](const Change& other) {
                return other.to != change.to || change.distance < other.distance;
            });
        });
        result.check(
            std::string(nameOf(way)) + ": a level comes back nearer by than it went",
            hasHysteresis && !back.empty(),
            std::to_string(back.size()) + " levels came back");
    }
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench
