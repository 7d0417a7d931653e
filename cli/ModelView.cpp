#include "ModelView.h"

#include "Arguments.h"
#include "Console.h"

#include <isofront/exchange/ModelFile.h>
#include <isofront/render/HandOver.h>

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

core::Result<Studio> openStudio(const ShownModel& model, const StudioOptions& options)
{
    auto device = gpu::Device::create({.device = options.device});
    if (!device)
        return tl::unexpected<core::Error>(device.error());
    Studio studio;
    studio.device = std::move(*device);
    constexpr std::uint32_t kNoMeshes = 1U << 16U; // [bytes]
    const voxels::StoredModel& stored = model.store->model();
    const render::RendererOptions usual;
    auto renderer = render::Renderer::create(
        *studio.device,
        options.hasSource ? render::voxelDomain(stored.lattice) : domainAround(model.box),
        {.width = options.width,
         .height = options.height,
         .poolBytes = options.hasSource ? usual.poolBytes : 2ULL * kNoMeshes,
         .slabBytes = options.hasSource ? usual.slabBytes : kNoMeshes,
         .samples = options.samples,
         .shadowMapSize = model.isLandscape ? 2048 : 16,
         .voxelPoolBytes = options.voxelBytes,
         .meshColours = options.hasSource && stored.coloured});
    if (!renderer)
        return tl::unexpected<core::Error>(renderer.error());
    studio.renderer = std::move(*renderer);
    dress(studio.scene, model);
    studio.scene.shadowInterval = options.shadowInterval;
    return studio;
}

core::Result<std::optional<glm::dvec3>> parseUp(const std::string& text)
{
    if (text.empty())
        return std::nullopt;
    const auto up = parsePoint(text, "--up");
    if (!up)
        return tl::unexpected(up.error());
    if (*up == glm::dvec3(0.0))
        return core::failure(core::ErrorCode::usage, "--up " + text + ": it must have a length");
    return *up;
}

void addVoxelOptions(CLI::App& command, double& voxelPixels, std::string& way, std::string& up)
{
    command
        .add_option("--voxel-pixels", voxelPixels, "voxel models: size of the largest voxel [px]")
        ->check(within(0.05, 1000.0))
        ->capture_default_str();
    command
        .add_option(
            "--way",
            way,
            "voxel models: how voxels are drawn, as 'cubes', 'splats', or 'auto' by their size")
        ->check(CLI::IsMember({"auto", "cubes", "splats"}))
        ->capture_default_str();
    command.add_option("--up", up, "voxel models: X,Y,Z away from the ground");
}

void addCacheOption(CLI::App& command, std::uint64_t& mib, const std::string& whose)
{
    command.add_option("--cache-mib", mib, whose + "memory for voxels on the device")
        ->check(CLI::Range(1, 4095))
        ->capture_default_str();
}

core::Error withCache(const core::Error& error, std::uint64_t cacheBytes)
{
    return withOption(error, "--cache-mib", grouped(cacheBytes >> 20U));
}

std::string coarserVoxelsNote(double asked, double effective, std::uint64_t cacheBytes)
{
    if (!(effective > asked))
        return {};
    // with the eye among the voxels of a coarse chunk, their size has no bound
    constexpr double kMostTold = 1000;
    const std::string size =
        effective <= kMostTold ? "up to " + brief(effective) : "more than " + brief(kMostTold);
    return "note: voxels are " + size + " px large, because " + grouped(cacheBytes >> 20U) +
           " MiB hold no more (see --cache-mib)";
}

render::VoxelWay voxelWay(const std::string& word)
{
    return word == "cubes"    ? render::VoxelWay::cubes
           : word == "splats" ? render::VoxelWay::splats
                              : render::VoxelWay::automatic;
}

} // namespace isofront::cli
