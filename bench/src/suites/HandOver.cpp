// How much pictures of one surface differ where voxels take the place of meshes.

#include "../Subjects.h"
#include "Models.h"
#include "Suites.h"

#include <isofront/gpu/Device.h>
#include <isofront/render/HandOver.h>
#include <isofront/render/Renderer.h>
#include <isofront/surface/Surface.h>
#include <isofront/voxels/FieldVoxelization.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

/// Error of the mesh that shows how far meshes are off among themselves [px].
constexpr double kFiner = 0.5;

/// What a picture shows, and where.
struct Shot {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba;
    std::vector<double> distance; ///< along the view direction [world]; infinite where nothing is

    [[nodiscard]] bool isCovered(int x, int y) const
    {
        return x >= 0 && y >= 0 && x < width && y < height &&
               std::isfinite(distance[static_cast<std::size_t>(y * width + x)]);
    }
    /// Whether a pixel is covered and one next to it is not.
    [[nodiscard]] bool isOutline(int x, int y) const
    {
        return isCovered(x, y) && !(isCovered(x - 1, y) && isCovered(x + 1, y) &&
                                    isCovered(x, y - 1) && isCovered(x, y + 1));
    }
};

/// The numbers of one comparison.
struct Disagreement {
    double silhouette = 0;     ///< between the outlines, the mean [px]
    double mostSilhouette = 0; ///< from a pixel of one outline to the other, the most [px]
    double depth = 0;    ///< along rays that meet both, as seen from the side, the median [px]
    double depthP95 = 0; ///< 95 % of them are below [px]
    double bias = 0;     ///< how much nearer the other is, the median [px]
    double colour = 0;   ///< of pixels that both cover, the mean [grey levels]
};

/// From each pixel of one outline to the nearest of the other, at most `kReach` [px].
double mostBetweenOutlines(const Shot& from, const Shot& to)
{
    constexpr int kReach = 16;
    int most = 0; // squared
    for (int y = 0; y < from.height; ++y)
        for (int x = 0; x < from.width; ++x) {
            if (!from.isOutline(x, y))
                continue;
            int least = kReach * kReach;
            for (int j = -kReach; j <= kReach; ++j)
                for (int i = -kReach; i <= kReach; ++i)
                    if (i * i + j * j < least && to.isOutline(x + i, y + j))
                        least = i * i + j * j;
            most = std::max(most, least);
        }
    return std::sqrt(static_cast<double>(most));
}

double quantileOf(std::vector<double>& values, double share)
{
    if (values.empty())
        return std::numeric_limits<double>::quiet_NaN();
    const auto at = values.begin() +
                    static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::ranges::nth_element(values, at);
    return *at;
}

Disagreement between(const Shot& mesh, const Shot& other, double pixelsPerUnit)
{
    Disagreement result;
    std::size_t odd = 0;
    std::size_t outline = 0;
    std::size_t both = 0;
    double grey = 0;
    std::vector<double> apart;
    std::vector<double> signedApart;
    for (int y = 0; y < mesh.height; ++y)
        for (int x = 0; x < mesh.width; ++x) {
            const auto at = static_cast<std::size_t>(y * mesh.width + x);
            outline += mesh.isOutline(x, y) ? 1U : 0U;
            const bool first = mesh.isCovered(x, y);
            if (first != other.isCovered(x, y))
                ++odd;
            else if (first) {
                ++both;
                const double pixels =
                    pixelsPerUnit * (mesh.distance[at] - other.distance[at]) / mesh.distance[at];
                apart.push_back(std::abs(pixels));
                signedApart.push_back(pixels);
                for (std::size_t channel = 0; channel < 3; ++channel)
                    grey += std::abs(
                        static_cast<int>(mesh.rgba[4 * at + channel]) -
                        static_cast<int>(other.rgba[4 * at + channel]));
            }
        }
    result.silhouette =
        static_cast<double>(odd) / static_cast<double>(std::max<std::size_t>(outline, 1));
    result.mostSilhouette =
        std::max(mostBetweenOutlines(mesh, other), mostBetweenOutlines(other, mesh));
    result.depth = quantileOf(apart, 0.5);
    result.depthP95 = quantileOf(apart, 0.95);
    result.bias = quantileOf(signedApart, 0.5);
    result.colour = grey / (3 * static_cast<double>(std::max<std::size_t>(both, 1)));
    return result;
}

/// Draws a subject from one place, as meshes and as voxels.
class Photographer {
public:
    static core::Result<Photographer>
    create(const Context& context, const Subject& subject, int width, int height)
    {
        Photographer made;
        made._context = &context;
        made._subject = &subject;
        auto device = gpu::Device::create();
        if (!device)
            return tl::unexpected(device.error());
        made._device = std::move(*device);
        const core::Box box = subject.domain.fieldBox(); // fields of subjects are the world's
        const glm::dvec3 ahead = glm::normalize(glm::dvec3(0.36, 0.80, -0.48));
        made._view.eye = box.centre() - kDistance * subject.domain.edge * ahead;
        made._view.forward = ahead;
        made._view.verticalFieldOfView = 0.6;
        made._view.width = width;
        made._view.height = height;
        made._scene.look = render::Look::studio;
        made._scene.antialias = false;
        return made;
    }

    [[nodiscard]] double pixelsPerUnit() const { return _view.pixelsPerUnit(); }
    [[nodiscard]] std::string deviceName() const { return _device->description().name; }
    /// What a length at the middle of the subject covers there.
    [[nodiscard]] double lengthOf(double pixels) const
    {
        return pixels * kDistance * _subject->domain.edge / pixelsPerUnit();
    }

    /// @param pixelError  that is asked for [px]
    core::Result<Shot> mesh(double pixelError)
    {
        surface::SurfaceOptions options;
        options.extraction.latticeSize = 16;
        options.extraction.isovalue = _subject->isovalue;
        options.extraction.closed = true;
        options.extraction.cornerRadius = lengthOf(1) / 16;
        options.pixelError = pixelError;
        surface::Surface surface(_subject->field, _subject->domain, options, _context->jobs);
        const surface::Delta delta = surface.settle(_view, {}, _context->stop);
        auto renderer = newRenderer();
        if (!renderer)
            return tl::unexpected(renderer.error());
        if (const auto applied = (*renderer)->apply(delta); !applied)
            return tl::unexpected(applied.error());
        return shoot(**renderer, {});
    }

    /// @param pixels  that a voxel's edge covers in the middle of the subject [px]
    core::Result<Shot> voxels(double pixels)
    {
        const auto store = voxels::memoryStore();
        const Cancellation cancellation(*_context);
        const auto made = voxels::voxelizeField(
            *_subject->field,
            {.isovalue = _subject->isovalue,
             .box = _subject->domain.fieldBox(),
             .edge = lengthOf(pixels),
             .closed = true},
            *store,
            *_context->jobs,
            cancellation.flag());
        if (!made)
            return tl::unexpected(made.error());
        std::vector<voxels::Chunk> chunks;
        std::vector<render::VoxelDraw> draws;
        for (const voxels::ChunkKey& key : store->keys())
            if (key.level == 0) {
                chunks.push_back(**store->get(key));
                draws.push_back({key});
            }
        auto renderer = newRenderer();
        if (!renderer)
            return tl::unexpected(renderer.error());
        if (const auto added = (*renderer)->addChunks(chunks); !added)
            return tl::unexpected(added.error());
        return shoot(**renderer, {.lattice = made->lattice, .draws = draws});
    }

private:
    static constexpr double kDistance = 1.9; ///< of the eye from the middle [edges of the domain]

    Photographer() = default;

    core::Result<std::unique_ptr<render::Renderer>> newRenderer()
    {
        return render::Renderer::create(
            *_device,
            _subject->domain,
            {.width = _view.width, .height = _view.height, .poolBytes = 512U << 20U});
    }
    core::Result<Shot> shoot(render::Renderer& renderer, const render::VoxelScene& voxels)
    {
        const auto drawn = renderer.draw(_view, _scene, voxels);
        if (!drawn)
            return tl::unexpected(drawn.error());
        auto image = renderer.readImage();
        const auto depth = renderer.readDepth();
        if (!image || !depth)
            return tl::unexpected(!image ? image.error() : depth.error());
        Shot shot;
        shot.width = image->width;
        shot.height = image->height;
        shot.rgba = std::move(image->rgba);
        for (const float d : *depth)
            shot.distance.push_back(renderer.defaultNearPlane() / static_cast<double>(d));
        return shot;
    }

    const Context* _context = nullptr;
    const Subject* _subject = nullptr;
    std::unique_ptr<gpu::Device> _device;
    hierarchy::View _view;
    render::Scene _scene;
};

Table disagreementTable()
{
    Table table{
        "disagreement",
        "Pictures of meshes to one pixel, and of what could take their place",
        {{"field", "", "what is shown"},
         {"instead", "", "of the mesh"},
         {"size", "px", "edge of a voxel in the middle of the picture, or error of the mesh"},
         {"silhouette", "px", "between the outlines, the mean"},
         {"most_silhouette", "px", "from a pixel of one outline to the other, the most"},
         {"depth", "px", "along rays, as it would be seen from the side, the median"},
         {"depth_p95", "px", "along rays: 95 % are below"},
         {"nearer", "px", "how much nearer it is along rays, the median"},
         {"colour", "grey", "of pixels that both cover, the mean"}},
        {},
        {}};
    for (const auto& [column, title] :
         {std::pair{"silhouette", "Distance between the outlines"},
          std::pair{"depth", "Distance along rays"},
          std::pair{"colour", "Difference of colours"}}) {
        Plot plot;
        plot.name = column;
        plot.title = title;
        plot.x = "size";
        plot.y = column;
        plot.series = "field";
        plot.whereColumn = "instead";
        plot.whereWord = "voxels";
        table.plots.push_back(std::move(plot));
    }
    return table;
}

} // namespace

SuiteResult runHandOver(const Context& context)
{
    SuiteResult result;
    const auto fail = [&](const core::Error& error) {
        noteUndrawn(result, context, error);
        return result;
    };
    Table table = disagreementTable();
    std::vector<Subject> subjects{torusSubject(), canyonSubject()};
    if (context.isFull())
        subjects.insert(subjects.begin() + 1, gyroidSubject());
    for (const Subject& subject : subjects) {
        auto photographer =
            Photographer::create(context, subject, context.pick(160, 960), context.pick(90, 540));
        if (!photographer)
            return fail(photographer.error());
        result.notes = {"drawn by " + photographer->deviceName()};
        context.say(subject.name + ", meshes");
        const auto mesh = photographer->mesh(1);
        if (!mesh)
            return fail(mesh.error());
        const auto compare = [&](const std::string& what, double size, const Shot& shot) {
            const Disagreement apart = between(*mesh, shot, photographer->pixelsPerUnit());
            table.add(
                {subject.name,
                 what,
                 size,
                 apart.silhouette,
                 apart.mostSilhouette,
                 apart.depth,
                 apart.depthP95,
                 apart.bias,
                 apart.colour});
            return apart;
        };
        const auto finer = photographer->mesh(kFiner);
        if (!finer)
            return fail(finer.error());
        compare("mesh", kFiner, *finer);
        // where the hand-over is, unless another is asked for
        const double usual = render::HandOverSettings{}.pixels / render::kVoxelError;
        for (const double size :
             context.pick<std::vector<double>>({0.5, usual, 2}, {0.5, usual, 1, 1.5, 2})) {
            if (context.isStopped())
                return result;
            context.say(subject.name + ", voxels of " + textOf(size) + " px");
            const auto voxels = photographer->voxels(size);
            if (!voxels)
                return fail(voxels.error());
            const Disagreement apart = compare("voxels", size, *voxels);
            // a cube sticks out by less than its edge, on the mean; and pixels have a grain
            const double allowed = 1.1 * size + 0.25;
            result.check(
                subject.name + ": outlines of voxels of " + textOf(size) +
                    " px lie not much more than a voxel off, the mean",
                apart.silhouette < allowed,
                textOf(apart.silhouette) + " px");
            result.check(
                subject.name + ": voxels of " + textOf(size) +
                    " px lie not much more than a voxel off along rays, the median",
                apart.depth < allowed,
                textOf(apart.depth) + " px");
            if (size == usual)
                result.check(
                    subject.name + ": at the hand-over outlines and surfaces lie less than a pixel "
                                   "off, the mean and the median",
                    std::max(apart.silhouette, apart.depth) < 1,
                    textOf(apart.silhouette) + " and " + textOf(apart.depth) + " px");
        }
    }
    result.tables.push_back(std::move(table));
    return result;
}

} // namespace isofront::bench
