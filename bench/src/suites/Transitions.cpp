// How a level of detail changes into the next: figure 5 of Jablonski and Martyn.

#include "Models.h"
#include "Suites.h"
#include "VoxelStudio.h"

#include <isofront/core/Image.h>
#include <isofront/voxels/LevelTransition.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

/// How much two pictures of one size differ: the mean over their pixels and channels [grey levels].
double differenceOf(const core::Image& a, const core::Image& b)
{
    double sum = 0;
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        sum += std::abs(static_cast<int>(a.rgba[i]) - static_cast<int>(b.rgba[i]));
    return 4 * sum / (3 * static_cast<double>(std::max<std::size_t>(a.rgba.size(), 1)));
}

std::size_t coverageOf(const std::vector<float>& depth)
{
    return static_cast<std::size_t>(std::ranges::count_if(depth, [](float d) { return d > 0; }));
}

struct Shot {
    core::Image image;
    std::vector<float> depth;
    std::uint64_t nodes = 0;
};

/// A model of which each chunk is on its way from its parent.
class Fading {
public:
    static core::Result<Fading> create(const Context& context);

    core::Result<Shot> shoot(float weight)
    {
        for (render::VoxelDraw& draw : _draws)
            draw.weight = weight;
        Shot shot;
        const auto drawn = _studio->renderer().draw(
            _view, _studio->scene(), {.lattice = _lattice, .draws = _draws});
        if (!drawn)
            return tl::unexpected(drawn.error());
        auto image = _studio->renderer().readImage();
        auto depth = _studio->renderer().readDepth();
        if (!image || !depth)
            return tl::unexpected(!image ? image.error() : depth.error());
        shot.image = std::move(*image);
        shot.depth = std::move(*depth);
        shot.nodes = drawn->voxels.voxels;
        return shot;
    }
    [[nodiscard]] std::string deviceName() const { return _studio->deviceName(); }

private:
    std::unique_ptr<VoxelStudio> _studio;
    voxels::VoxelLattice _lattice;
    hierarchy::View _view;
    std::vector<render::VoxelDraw> _draws;
};

core::Result<Fading> Fading::create(const Context& context)
{
    Fading fading;
    glm::dvec3 up(0, 0, 1);
    voxels::TriangleModel model;
    if (auto dragon = context.isFull() ? modelFile(context, kDragon) : std::nullopt) {
        model = std::move(*dragon);
        up = {0, 1, 0};
    } else {
        model = hills(60);
    }
    auto store = inMemory(context, "the model", model, 300);
    if (!store)
        return tl::unexpected(store.error());
    auto studio = VoxelStudio::create(
        *store, {.width = context.pick(160, 960), .height = context.pick(120, 720), .up = up});
    if (!studio)
        return tl::unexpected(studio.error());
    fading._studio = std::move(*studio);
    fading._lattice = (*store)->model().lattice;
    const core::Box box = boundsOf(model);
    const glm::dvec3 back =
        glm::normalize(up.y > 0.5 ? glm::dvec3(0.3, 0.35, 1) : glm::dvec3(-0.3, -1, 0.35));
    fading._view = fading._studio->view(
        box.centre() + 0.75 * glm::length(box.size()) * back, box.centre(), 1.0);

    std::vector<voxels::Chunk> chunks;
    std::vector<render::VoxelTransition> transitions;
    for (const voxels::ChunkKey& key : (*store)->keys())
        if (key.level < 2)
            chunks.push_back(**(*store)->get(key));
    for (const voxels::Chunk& chunk : chunks) {
        if (chunk.key.level != 0)
            continue;
        const auto parent = std::ranges::find(chunks, chunk.key.parent(), &voxels::Chunk::key);
        auto nodes = voxels::transitionNodes(chunk, *parent);
        if (!nodes)
            return tl::unexpected(nodes.error());
        transitions.push_back({chunk.key, std::move(*nodes)});
        fading._draws.push_back({chunk.key});
    }
    render::Renderer& renderer = fading._studio->renderer();
    if (const auto added = renderer.addChunks(chunks); !added)
        return tl::unexpected(added.error());
    if (const auto added = renderer.addTransitions(transitions); !added)
        return tl::unexpected(added.error());
    return fading;
}

} // namespace

SuiteResult runTransitions(const Context& context)
{
    SuiteResult result;
    const auto fail = [&](const core::Error& error) {
        noteUndrawn(result, context, error);
        return result;
    };
    auto fading = Fading::create(context);
    if (!fading)
        return fail(fading.error());
    result.notes = {"drawn by " + fading->deviceName()};

    constexpr int kSteps = 32;
    std::vector<Shot> shots;
    double thereAndBack = 0;
    for (int i = 0; i <= 2 * kSteps; ++i) {
        if (context.isStopped())
            return result;
        const int step = std::min(i, 2 * kSteps - i);
        if (i % 8 == 0)
            context.say("weight " + std::to_string(step) + "/" + std::to_string(kSteps));
        auto shot = fading->shoot(static_cast<float>(step) / kSteps);
        if (!shot)
            return fail(shot.error());
        if (i <= kSteps)
            shots.push_back(std::move(*shot));
        else
            thereAndBack = std::max(
                thereAndBack,
                differenceOf(shot->image, shots[static_cast<std::size_t>(step)].image));
    }

    Table table{
        "transition",
        "A level changes into the next finer one",
        {{"weight", "", "weight: 0 looks like the coarser level, 1 like the finer"},
         {"from_coarser", "grey", "mean difference of pixels from those of the coarser level"},
         {"from_finer", "grey", "the same from the finer one"},
         {"step", "grey", "the same from the weight before"},
         {"covered", "px", "that the model covers"},
         {"nodes", "M", "drawn: voxels and redundant nodes"}},
        {},
        {}};
    for (const auto& [column, title] :
         {std::pair{"from_coarser", "Difference from the coarser level"},
          std::pair{"from_finer", "Difference from the finer level"},
          std::pair{"step", "Difference from the step before"},
          std::pair{"covered", "Pixels that the model covers"}}) {
        Plot plot;
        plot.name = column;
        std::ranges::replace(plot.name, '_', '-');
        plot.title = title;
        plot.x = "weight";
        plot.y = column;
        table.plots.push_back(std::move(plot));
    }
    const double whole = differenceOf(shots.front().image, shots.back().image);
    double most = 0;
    double backwards = 0;
    double before = whole;
    for (std::size_t i = 0; i < shots.size(); ++i) {
        const double step = i > 0 ? differenceOf(shots[i].image, shots[i - 1].image) : 0;
        const double left = differenceOf(shots[i].image, shots.back().image);
        most = std::max(most, step);
        backwards = std::max(backwards, left - before);
        before = left;
        table.add(
            {static_cast<double>(i) / kSteps,
             differenceOf(shots[i].image, shots.front().image),
             left,
             step,
             count(coverageOf(shots[i].depth)),
             1e-6 * static_cast<double>(shots[i].nodes)});
    }
    result.check(
        "the way back shows the same pictures",
        thereAndBack == 0,
        textOf(thereAndBack) + " grey levels apart");
    result.check(
        "no step of 1/32 changes the picture by more than an eighth of the whole",
        whole > 0 && most < whole / 8,
        textOf(most) + " of " + textOf(whole) + " grey levels");
    result.check(
        "each step comes nearer to the finer level, but for a hundredth of the way",
        backwards < 0.01 * whole,
        textOf(backwards) + " grey levels further away at most");
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench
