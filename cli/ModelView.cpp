#include "ModelView.h"

#include <isofront/exchange/ModelFile.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

namespace isofront::cli {

namespace {

/// Models have y up; scans, landscapes and formulas z.
bool isUpright(const std::string& name)
{
    return exchange::isModelName(name) || name.ends_with(".vdb");
}

/// A cube around a box, for the renderer: it sets the near plane.
hierarchy::Domain domainAround(const core::Box& box)
{
    const glm::dvec3 size = box.size();
    return {.origin = box.low, .edge = std::max({size.x, size.y, size.z})};
}

void dress(render::Scene& scene, const ShownModel& model)
{
    scene.up = model.up;
    scene.look = model.isLandscape ? render::Look::terrain : render::Look::studio;
    if (!model.isLandscape)
        return;
    const std::string& name = model.store->model().name;
    const std::string_view key = "preset=";
    const std::size_t preset = name.find(key);
    if (preset != std::string::npos) {
        const std::string kind = name.substr(preset + key.size());
        scene.terrain = render::terrainLook(kind.substr(0, kind.find('&')));
    }
}

} // namespace

core::Result<ShownModel>
openModel(const std::filesystem::path& path, const std::optional<glm::dvec3>& up)
{
    auto opened = voxels::openAnyStore(path);
    if (!opened)
        return tl::unexpected(opened.error());
    ShownModel model;
    model.store = std::move(*opened);
    const auto box = voxels::worldBox(*model.store);
    if (!box)
        return tl::unexpected(box.error());
    if (box->isEmpty())
        return core::failure(
            core::ErrorCode::badData, path.string() + ": the model has no voxels to show");
    model.box = *box;
    const std::string& name = model.store->model().name;
    model.isLandscape = name.starts_with("proc:terrain");
    if (up)
        model.up = glm::normalize(*up);
    else
        model.up = isUpright(name) ? glm::dvec3(0, 1, 0) : glm::dvec3(0, 0, 1);
    return model;
}

glm::dvec3 forwardTo(const ShownModel& model)
{
    const glm::dvec3& up = model.up;
    const glm::dvec3 front = up.y > 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, -1, 0);
    return -glm::normalize(front + 0.45 * glm::cross(up, front) + 0.4 * up);
}

double shadowDistance(const ShownModel& model, const glm::dvec3& eye)
{
    const core::Box& box = model.box;
    const glm::dvec3 farthest = glm::max(glm::abs(box.low - eye), glm::abs(box.high - eye));
    return 1.1 * glm::length(farthest); // it is a square, most of which lies before the eye
}

core::Result<Studio>
openStudio(const ShownModel& model, const StudioOptions& options, std::uint64_t cacheBytes)
{
    auto device = gpu::Device::create({.device = options.device});
    if (!device)
        return tl::unexpected<core::Error>(device.error());
    Studio studio;
    studio.device = std::move(*device);
    constexpr std::uint32_t kNoMeshes = 1U << 16U; // [bytes]
    auto renderer = render::Renderer::create(
        *studio.device,
        domainAround(model.box),
        {.width = options.width,
         .height = options.height,
         .poolBytes = 2ULL * kNoMeshes,
         .slabBytes = kNoMeshes,
         .samples = options.samples,
         .shadowMapSize = model.isLandscape ? 2048 : 16,
         .voxelPoolBytes = cacheBytes});
    if (!renderer)
        return tl::unexpected<core::Error>(renderer.error());
    studio.renderer = std::move(*renderer);
    dress(studio.scene, model);
    studio.scene.shadowInterval = options.shadowInterval;
    return studio;
}

} // namespace isofront::cli
