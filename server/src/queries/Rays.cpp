#include "Rays.h"

#include <isofront/fields/FieldRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

namespace isofront::server {
namespace {

/// How many rays are one job.
constexpr std::size_t kBlock = 16;

/// How closely a source is sampled along a ray where its bounds say nothing [field]: an eighth of
/// its voxels, or so small a part of the domain's edge.
double stepOf(const sources::Source& source)
{
    return source.voxel ? *source.voxel / 8 : std::ldexp(source.domain.edge, -14);
}

core::Box boxOf(const sources::Source& source)
{
    core::Box box = source.domain.fieldBox();
    if (const auto data = source.field->dataBox()) {
        box.low = glm::max(box.low, data->low);
        box.high = glm::min(box.high, data->high);
    }
    return box;
}

core::Result<std::optional<WorldHit>> castOne(
    const sources::Source& source,
    const fields::FieldRaySettings& settings,
    const core::Box& box,
    const core::Affine& fieldFromWorld,
    const WorldRay& ray)
{
    // lengths of any order: the square of none is needed
    const glm::dvec3 size = glm::abs(ray.direction);
    const glm::dvec3 direction = glm::normalize(ray.direction / std::max({size.x, size.y, size.z}));
    const auto inside = fields::clipped(
        {fieldFromWorld.point(ray.origin),
         fieldFromWorld.direction(direction),
         0,
         std::numeric_limits<double>::infinity()},
        box);
    if (!inside)
        return std::optional<WorldHit>();
    const auto found = fields::castRay(*source.field, *inside, settings);
    if (!found)
        return tl::unexpected(found.error());
    if (!*found)
        return std::optional<WorldHit>();
    WorldHit hit;
    hit.distance = (*found)->t;
    hit.point = ray.origin + hit.distance * direction;
    const glm::dvec3 normal = -(source.domain.worldFromField.normalMatrix() * (*found)->gradient);
    if (const double length = glm::length(normal); length > 0 && std::isfinite(length))
        hit.normal = normal / length;
    return std::optional(hit);
}

} // namespace

core::Result<std::vector<std::optional<WorldHit>>> castRays(
    const sources::Source& source,
    double isovalue,
    std::span<const WorldRay> rays,
    core::Jobs& jobs,
    const std::stop_token& stop)
{
    const fields::FieldRaySettings settings{
        .isovalue = source.fieldIsovalue(isovalue), .step = stepOf(source), .stop = stop};
    const core::Box box = boxOf(source);
    const core::Affine fieldFromWorld = source.domain.worldFromField.inverse();
    std::vector<std::optional<WorldHit>> hits(rays.size());
    jobs.parallelFor((rays.size() + kBlock - 1) / kBlock, [&](std::size_t block) {
        const std::size_t end = std::min(rays.size(), (block + 1) * kBlock);
        for (std::size_t i = block * kBlock; i < end; ++i) {
            const auto hit = castOne(source, settings, box, fieldFromWorld, rays[i]);
            if (!hit)
                return;
            hits[i] = *hit;
        }
    });
    if (stop.stop_requested())
        return core::failure(
            core::ErrorCode::interrupted, "there was no time for all of it: ask for less at once");
    return hits;
}

WorldRay rayFromAbove(const sources::Source& source, const glm::dvec3& place)
{
    const core::Affine& map = source.domain.worldFromField;
    const core::Box domain = source.domain.fieldBox();
    const glm::dvec3 up = glm::normalize(source.up);
    double highest = -std::numeric_limits<double>::infinity();
    for (int corner = 0; corner < 8; ++corner) {
        const glm::dvec3 point(
            (corner & 1) != 0 ? domain.high.x : domain.low.x,
            (corner & 2) != 0 ? domain.high.y : domain.low.y,
            (corner & 4) != 0 ? domain.high.z : domain.low.z);
        highest = std::max(highest, glm::dot(map.point(point), up));
    }
    return {place + (highest - glm::dot(place, up)) * up, -up};
}

} // namespace isofront::server
