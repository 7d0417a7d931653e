// What a picture of a scan takes: drawn as voxels, or by rays through voxels and triangles, on the
// same cores.

#include "../EmbreeModel.h"
#include "Models.h"
#include "Suites.h"
#include "VoxelStudio.h"
#include "isofront/bench/Timing.h"

#include <isofront/voxels/VoxelRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

constexpr double kFieldOfView = 1.0;
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kRuns = 7;

struct Subject {
    std::string name;
    voxels::TriangleModel model;
    glm::dvec3 up{0, 0, 1};
    std::shared_ptr<const voxels::ChunkStore> store;
};

core::Result<Subject> subjectFor(const Context& context)
{
    Subject subject;
    if (auto dragon = context.isFull() ? modelFile(context, kDragon) : std::nullopt) {
        subject.name = "dragon";
        subject.up = {0, 1, 0};
        subject.model = std::move(*dragon);
    } else {
        subject.name = "hills";
        subject.model = hills(context.pick(60U, 600U));
    }
    auto store = inMemory(context, subject.name, subject.model, context.pick(300U, 2048U));
    if (!store)
        return tl::unexpected(store.error());
    subject.store = std::move(*store);
    return subject;
}

/// A ray for each pixel of a view, by blocks of 4 x 4 pixels, so that sixteen in a row have much
/// in common. Width and height must be multiples of four.
std::vector<voxels::Ray> raysOf(const hierarchy::View& view)
{
    const glm::dvec3 ahead = glm::normalize(view.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, view.up));
    const glm::dvec3 above = glm::cross(right, ahead);
    const double step = 1 / view.pixelsPerUnit();
    std::vector<voxels::Ray> rays;
    for (int blockY = 0; blockY < view.height; blockY += 4)
        for (int blockX = 0; blockX < view.width; blockX += 4)
            for (int i = 0; i < 16; ++i) {
                const double x = blockX + i % 4 + 0.5 - 0.5 * view.width;
                const double y = blockY + i / 4 + 0.5 - 0.5 * view.height;
                rays.push_back(
                    {.start = view.eye,
                     .direction = glm::normalize(ahead + step * (x * right - y * above))});
            }
    return rays;
}

Table pictureTable()
{
    return {
        "pictures",
        "A picture by each way, on all cores",
        {{"view", "", "the whole model, or close by"},
         {"what", "", "is drawn or met"},
         {"time", "ms", "by the clock, the least of the runs"},
         {"cpu", "ms", "processor time of it, all threads, the least of the runs"},
         {"covered", "%", "of the picture"},
         {"items", "M", "voxels drawn, or triangles"},
         {"memory", "MiB", "that the picture needs, with what items are found by"},
         {"build", "s", "processor time that what items are found by takes to make"}},
        {},
        {}};
}

class Views {
public:
    Views(const Context& context, const Subject& subject, SuiteResult& result, Table& table)
        : _context(context), _subject(subject), _result(result), _table(table)
    {
        const auto took =
            timed([&] { _embree.emplace(subject.model, boundsOf(subject.model).low); }, 1);
        _embreeSeconds = took.least;
    }

    core::Result<void> measure(const std::string& name, double diagonals)
    {
        const core::Box box = boundsOf(_subject.model);
        const glm::dvec3 back = glm::normalize(
            _subject.up.y > 0.5 ? glm::dvec3(0.3, 0.35, 1) : glm::dvec3(-0.3, -1, 0.35));
        const glm::dvec3 eye = box.centre() + diagonals * glm::length(box.size()) * back;
        std::optional<hierarchy::View> view;
        for (const double pixels : {1.0, 2.0}) {
            if (_context.isStopped())
                return {};
            _context.say(name + ", voxels of " + textOf(pixels) + " px");
            auto studio = VoxelStudio::create(
                _subject.store,
                {.width = _context.pick(240, 1280),
                 .height = _context.pick(136, 720),
                 .up = _subject.up,
                 .streaming = {.voxelPixels = pixels}});
            if (!studio)
                return tl::unexpected(studio.error());
            view = (*studio)->view(eye, box.centre(), kFieldOfView);
            if (pixels == 1) {
                _result.notes = {"drawn by " + (*studio)->deviceName()};
                const auto nothing = (*studio)->view(eye, eye + (eye - box.centre()), kFieldOfView);
                if (const auto drawn = draw(**studio, nothing, name, "nothing, drawn"); !drawn)
                    return drawn;
            }
            if (const auto drawn =
                    draw(**studio, *view, name, "voxels of " + textOf(pixels) + " px, drawn");
                !drawn)
                return drawn;
        }
        const std::vector<voxels::Ray> rays = raysOf(*view);
        return castAll(name, rays, *view);
    }

private:
    core::Result<void> draw(
        VoxelStudio& studio,
        const hierarchy::View& view,
        const std::string& name,
        const std::string& what)
    {
        auto least = studio.settle(view);
        for (std::size_t i = 0; least && i < _context.pick<std::size_t>(1, kRuns); ++i) {
            const auto frame = studio.next(view);
            if (!frame)
                return tl::unexpected(frame.error());
            least->wall = std::min(least->wall, frame->wall);
            least->cpu = std::min(least->cpu, frame->cpu);
        }
        if (!least)
            return tl::unexpected(least.error());
        const auto depth = studio.renderer().readDepth();
        if (!depth)
            return tl::unexpected(depth.error());
        const auto covered =
            static_cast<std::size_t>(std::ranges::count_if(*depth, [](float d) { return d > 0; }));
        _drawn = 100.0 * static_cast<double>(covered) / static_cast<double>(depth->size());
        add(name,
            what,
            least->wall,
            least->cpu,
            _drawn,
            static_cast<double>(least->voxels),
            static_cast<double>(least->wantedBytes),
            kNone);
        return {};
    }

    core::Result<void> castAll(
        const std::string& name, const std::vector<voxels::Ray>& rays, const hierarchy::View& view)
    {
        const auto number = static_cast<double>(rays.size());
        const std::size_t runs = _context.pick<std::size_t>(1, kRuns);
        {
            // the finest level of which no voxel is smaller than a pixel
            const voxels::VoxelLattice& lattice = _subject.store->model().lattice;
            const core::Box box = boundsOf(_subject.model);
            const double nearest = std::max(
                glm::length(view.eye - box.centre()) - 0.5 * glm::length(box.size()), lattice.edge);
            std::uint32_t level = 0;
            while (level + 1 < lattice.levels &&
                   lattice.edge * std::exp2(level + 1) * view.pixelsPerUnit() <= nearest)
                ++level;
            _context.say(name + ", rays through voxels");
            const auto caster = voxels::VoxelRayCaster::create(
                *_subject.store, voxels::cutOfLevel(*_subject.store, level));
            if (!caster)
                return tl::unexpected(caster.error());
            core::Result<std::vector<std::optional<voxels::VoxelHit>>> hits;
            const auto cast = [&] { hits = caster->cast(rays, *_context.jobs); };
            cast(); // loads
            const Timing timing = timed(cast, runs);
            if (!hits)
                return tl::unexpected(hits.error());
            const auto met =
                std::ranges::count_if(*hits, [](const auto& hit) { return hit.has_value(); });
            add(name,
                "voxels of level " + std::to_string(level) + ", met by rays",
                timing.wall,
                timing.least,
                100 * static_cast<double>(met) / number,
                kNone,
                static_cast<double>(caster->statistics().bytes),
                kNone);
        }
        if (!_embree->isThere())
            return {};
        std::vector<peers::EmbreeRay> cast = _embree->raysOf(rays);
        const auto mesh = static_cast<double>(
            12 * (_subject.model.positions.size() + _subject.model.triangles.size()));
        for (const auto way : {EmbreeModel::Way::single, EmbreeModel::Way::packets}) {
            _context.say(name + ", Embree");
            const Timing timing = timed(
                [&] {
                    constexpr std::size_t kTask = 4096;
                    _context.jobs->parallelFor(
                        (cast.size() + kTask - 1) / kTask, [&](std::size_t task) {
                            const std::size_t first = task * kTask;
                            _embree->cast(
                                std::span(cast).subspan(
                                    first, std::min(kTask, cast.size() - first)),
                                way);
                        });
                },
                runs);
            const auto met =
                std::ranges::count_if(cast, [](const auto& ray) { return ray.distance >= 0; });
            const double share = 100 * static_cast<double>(met) / number;
            add(name,
                way == EmbreeModel::Way::single ? "triangles, met by Embree's rays"
                                                : "triangles, met by Embree's packets of 16",
                timing.wall,
                timing.least,
                share,
                static_cast<double>(_subject.model.triangles.size()),
                static_cast<double>(_embree->bytes()) + mesh,
                _embreeSeconds);
            _result.check(
                name + ": voxels of 2 px cover what triangles do, " +
                    (way == EmbreeModel::Way::single ? "one by one" : "in packets"),
                _drawn >= share && _drawn < 1.15 * share,
                textOf(_drawn) + " and " + textOf(share) + " % of the picture");
        }
        return {};
    }

    void
    add(const std::string& name,
        const std::string& what,
        double wall,
        double cpu,
        double covered,
        double items,
        double bytes,
        double build)
    {
        _table.add(
            {name,
             what,
             1e3 * wall,
             1e3 * cpu,
             covered,
             1e-6 * items,
             bytes / (1024.0 * 1024.0),
             build});
    }

    const Context& _context;
    const Subject& _subject;
    SuiteResult& _result;
    Table& _table;
    std::optional<EmbreeModel> _embree;
    double _embreeSeconds = 0;
    double _drawn = 0; ///< of the picture drawn last [%]
};

} // namespace

SuiteResult runPicture(const Context& context)
{
    SuiteResult result;
    const auto fail = [&](const core::Error& error) {
        noteUndrawn(result, context, error);
        return result;
    };
    const auto subject = subjectFor(context);
    if (!subject)
        return fail(subject.error());
    Table table = pictureTable();
    Views views(context, *subject, result, table);
    for (const auto& [name, diagonals] :
         {std::pair{subject->name + ", whole", 1.0}, std::pair{subject->name + ", close", 0.45}})
        if (const auto measured = views.measure(name, diagonals); !measured || context.isStopped())
            return measured ? result : fail(measured.error());
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench
