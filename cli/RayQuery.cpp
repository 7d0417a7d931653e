#include "RayQuery.h"

#include "Arguments.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <vector>

namespace isofront::cli {

namespace {

constexpr std::array<const char*, voxels::kFaces> kFaceNames{"-x", "+x", "-y", "+y", "-z", "+z"};

glm::dvec3 pointOf(const voxels::VoxelHit& hit, const voxels::Ray& ray)
{
    // scaled first: the square of a tiny or huge direction is no number
    const glm::dvec3 size = glm::abs(ray.direction);
    const glm::dvec3 direction = ray.direction / std::max({size.x, size.y, size.z});
    return ray.start + hit.distance * glm::normalize(direction);
}

} // namespace

core::Result<voxels::Ray> parseRay(const std::string& text)
{
    if (const auto numbers = parseNumbers(text, 6)) {
        const std::vector<double>& n = *numbers;
        const voxels::Ray ray{.start = {n[0], n[1], n[2]}, .direction = {n[3], n[4], n[5]}};
        if (ray.direction != glm::dvec3(0))
            return ray;
    }
    return core::failure(
        core::ErrorCode::usage,
        "--ray '" + text +
            "': give X,Y,Z,DX,DY,DZ in world units, a start and a direction that is not zero, as "
            "in 0,0,10,0.5,0,-1");
}

core::Result<std::optional<voxels::VoxelHit>>
castRay(const voxels::ChunkStore& store, const voxels::Ray& ray, std::uint32_t level)
{
    const std::uint32_t levels = store.model().lattice.levels;
    if (level >= levels)
        return core::failure(
            core::ErrorCode::usage,
            "--ray-level " + std::to_string(level) + ": the model has levels 0 to " +
                std::to_string(levels - 1));
    const auto caster = voxels::VoxelRayCaster::create(store, voxels::cutOfLevel(store, level));
    if (!caster)
        return tl::unexpected(caster.error());
    return caster->cast(ray);
}

nlohmann::ordered_json hitJson(const std::optional<voxels::VoxelHit>& hit, const voxels::Ray& ray)
{
    if (!hit)
        return nullptr;
    const glm::dvec3 point = pointOf(*hit, ray);
    nlohmann::ordered_json json;
    json["level"] = hit->chunk.level;
    json["voxel"] = hit->place;
    json["face"] = nullptr;
    if (hit->face)
        json["face"] = kFaceNames[static_cast<std::size_t>(*hit->face)];
    json["distance"] = hit->distance;
    json["point"] = {point.x, point.y, point.z};
    json["normal"] = {hit->normal.x, hit->normal.y, hit->normal.z};
    json["colour"] = nullptr;
    if (const auto colour = hit->colour)
        json["colour"] = {
            *colour & 0xffU, *colour >> 8U & 0xffU, *colour >> 16U & 0xffU, *colour >> 24U};
    return json;
}

std::string hitText(const std::optional<voxels::VoxelHit>& hit, const voxels::Ray& ray)
{
    if (!hit)
        return "meets no voxel";
    const glm::dvec3 point = pointOf(*hit, ray);
    std::array<char, 240> text{};
    std::snprintf(
        text.data(),
        text.size(),
        "voxel %u, %u, %u of level %u, %s%s, after %.9g at %.9g, %.9g, %.9g; normal %.3f, %.3f, "
        "%.3f",
        hit->place[0],
        hit->place[1],
        hit->place[2],
        hit->chunk.level,
        hit->face ? "face " : "from inside",
        hit->face ? kFaceNames[static_cast<std::size_t>(*hit->face)] : "",
        hit->distance,
        point.x,
        point.y,
        point.z,
        hit->normal.x,
        hit->normal.y,
        hit->normal.z);
    return text.data();
}

} // namespace isofront::cli
