#include "Pictures.h"

#include <isofront/hierarchy/Criterion.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace isofront::cli {

core::Result<Studio> openStudio(const Source& source, const StudioOptions& options)
{
    auto device = gpu::Device::create({.device = options.device});
    if (!device)
        return tl::unexpected<core::Error>(device.error());
    Studio studio;
    studio.device = std::move(*device);
    auto renderer = render::Renderer::create(
        *studio.device,
        source.domain,
        {.width = options.width, .height = options.height, .poolBytes = options.meshBytes});
    if (!renderer)
        return tl::unexpected<core::Error>(renderer.error());
    studio.renderer = std::move(*renderer);
    studio.scene.look = source.isTerrain ? render::Look::terrain : render::Look::studio;
    if (source.isTerrain)
        studio.scene.terrain = render::terrainLook(source.terrainKind);
    if (source.elevation) {
        const auto& info = source.elevation->info;
        const double relief = info.highest - info.lowest;
        studio.scene.terrain.baseHeight = info.lowest;
        studio.scene.terrain.grassLine = static_cast<float>(0.62 * relief);
        studio.scene.terrain.snowLine = static_cast<float>(0.92 * relief);
    }
    // the sun hardly moves, and shadows redraw every cell near the eye
    studio.scene.shadowInterval = options.shadowInterval;
    return studio;
}

hierarchy::View
viewTo(const glm::dvec3& eye, const glm::dvec3& target, double fovDegrees, int width, int height)
{
    hierarchy::View view;
    view.eye = eye;
    view.forward = target - eye;
    view.width = width;
    view.height = height;
    view.verticalFieldOfView = fovDegrees * std::numbers::pi / 180;
    const glm::dvec3 direction = glm::normalize(view.forward);
    if (std::abs(direction.z) > 0.999)
        view.up = {0, 1, 0}; // straight up or down: north is at the top
    return view;
}

surface::SurfaceOptions surfaceOptions(
    const Source& source,
    double isovalue,
    int lattice,
    double filter,
    double pixelError,
    bool closed,
    const MeshOptions& mesh,
    const DetailRequest& detail)
{
    surface::SurfaceOptions options;
    options.extraction.latticeSize = lattice;
    options.extraction.isovalue = source.fieldIsovalue(isovalue);
    options.extraction.filterStrength = filter;
    options.extraction.closed = closed;
    mesh.applyTo(options.extraction);
    options.pixelError = pixelError;
    detail.applyTo(options);
    if (!source.voxel)
        return options;
    const int native = levelForStep(*source.voxel / source.domain.edge, lattice);
    options.maxLevel = std::min(native + source.levelsBelowVoxel, hierarchy::kMaxLevel);
    options.extraction.cornerRadius = 2 * hierarchy::axisStep(native, lattice) * source.domain.edge;
    return options;
}

} // namespace isofront::cli
