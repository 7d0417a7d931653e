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
        {.width = options.width,
         .height = options.height,
         .poolBytes = options.meshBytes,
         .samples = options.samples,
         .voxelPoolBytes = options.voxelBytes});
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

namespace {

/// The part of the data that may have a surface, by the field's bounds [world]; all of it if none
/// has.
core::Box surfaceBox(const Source& source, double isovalue)
{
    constexpr int kParts = 16; // along each axis
    const core::Box whole = source.volume->dataBox;
    const glm::dvec3 step = whole.size() / double(kParts);
    const double level = source.fieldIsovalue(isovalue);
    const core::Affine& map = source.domain.worldFromField;
    core::Box found;
    for (int part = 0; part < kParts * kParts * kParts; ++part) {
        const glm::dvec3 at(part % kParts, part / kParts % kParts, part / (kParts * kParts));
        const core::Box box{whole.low + at * step, whole.low + (at + 1.0) * step};
        if (!source.field->bounds(box, {0, 0}).contains(level))
            continue;
        for (unsigned corner = 0; corner < 8; ++corner)
            found.include(map.point(
                {(corner & 1U) != 0 ? box.high.x : box.low.x,
                 (corner & 2U) != 0 ? box.high.y : box.low.y,
                 (corner & 4U) != 0 ? box.high.z : box.low.z}));
    }
    return found.isEmpty() ? source.worldBox : found;
}

} // namespace

glm::dvec3 placeBefore(
    const core::Box& box,
    const glm::dvec3& target,
    const glm::dvec3& forward,
    const glm::dvec3& up,
    double fovDegrees,
    int width,
    int height)
{
    constexpr double kFilled = 0.94; // of the picture's height or width
    const glm::dvec3 across = glm::cross(forward, up);
    const glm::dvec3 right =
        glm::normalize(glm::length(across) > 1e-3 ? across : glm::dvec3(1, 0, 0));
    const glm::dvec3 above = glm::cross(right, forward);
    const double tangentY = kFilled * std::tan(0.5 * fovDegrees * std::numbers::pi / 180);
    const double tangentX = tangentY * width / height;
    double distance = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const glm::dvec3 at = glm::dvec3(
                                  (corner & 1U) != 0 ? box.high.x : box.low.x,
                                  (corner & 2U) != 0 ? box.high.y : box.low.y,
                                  (corner & 4U) != 0 ? box.high.z : box.low.z) -
                              target;
        const double aside = std::max(
            std::abs(glm::dot(at, right)) / tangentX, std::abs(glm::dot(at, above)) / tangentY);
        distance = std::max(distance, aside - glm::dot(at, forward));
    }
    return target - distance * forward;
}

void frameSurface(
    Source& source, double isovalue, bool keepsTarget, double fovDegrees, int width, int height)
{
    const glm::dvec3 forward = glm::normalize(source.target - source.eye);
    const core::Box box = surfaceBox(source, isovalue);
    if (!keepsTarget)
        source.target = box.centre();
    source.eye = placeBefore(box, source.target, forward, source.up, fovDegrees, width, height);
}

hierarchy::View viewTo(
    const glm::dvec3& eye,
    const glm::dvec3& target,
    double fovDegrees,
    int width,
    int height,
    const glm::dvec3& up)
{
    hierarchy::View view;
    view.eye = eye;
    view.forward = target - eye;
    view.width = width;
    view.height = height;
    view.verticalFieldOfView = fovDegrees * std::numbers::pi / 180;
    const glm::dvec3 direction = glm::normalize(view.forward);
    view.up = up;
    if (std::abs(glm::dot(direction, up)) > 0.999)
        view.up = {up.y, up.z, up.x}; // straight up or down: north is at the top
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
