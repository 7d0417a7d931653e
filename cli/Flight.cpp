#include "Flight.h"

#include "Pictures.h"

#include <isofront/fields/Terrain.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>

namespace isofront::cli {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMostLand = 20'000; // [m]
/// The land is so many times as wide as a flight is high above it.
constexpr double kClearances = 180;
constexpr double kVoxelsBelow = 24; ///< a flight over voxels keeps clear of so many

/// The largest value within so many entries of each, then their mean over as many: a curve that
/// lies above the values and has no corners.
std::vector<double> smoothlyAbove(const std::vector<double>& values, std::size_t reach)
{
    const auto window = [&](const std::vector<double>& from, auto&& combine) {
        std::vector<double> result(from.size());
        for (std::size_t i = 0; i < from.size(); ++i) {
            const std::size_t begin = i < reach ? 0 : i - reach;
            const std::size_t end = std::min(from.size(), i + reach + 1);
            result[i] =
                combine(from.begin() + std::ptrdiff_t(begin), from.begin() + std::ptrdiff_t(end));
        }
        return result;
    };
    const auto highest =
        window(values, [](auto begin, auto end) { return *std::max_element(begin, end); });
    const auto mean = [](auto begin, auto end) {
        double sum = 0;
        for (auto it = begin; it != end; ++it)
            sum += *it;
        return sum / double(end - begin);
    };
    return window(window(highest, mean), mean);
}

/// What a flight over land needs to know of it.
struct Land {
    core::Box box;   ///< [world]
    double edge = 1; ///< what the land is large as [world]
    glm::dvec3 eye;  ///< where to begin [world]
    glm::dvec3 towards;
    double clearance = 0;                             ///< [world]
    std::function<double(double x, double y)> ground; ///< its height
};

std::vector<hierarchy::View> overLand(const Land& land, const FlightPlan& plan)
{
    const core::Box& box = land.box;
    const double edge = land.edge;
    const double speed = plan.speed > 0 ? plan.speed : edge / 80;

    // Along a wide bend towards the middle of the domain, with a swing to both sides.
    const glm::dvec3& towards = land.towards;
    const double heading = std::atan2(towards.y, towards.x);
    const glm::dvec3 middle = box.centre() - land.eye;
    const double side = towards.x * middle.y - towards.y * middle.x >= 0 ? 1.0 : -1.0;
    const double bend = side / (0.25 * edge); // curvature
    const std::size_t count = plan.frames + 1;
    std::vector<glm::dvec3> path(count);
    glm::dvec3 at = land.eye;
    for (std::size_t i = 0; i < count; ++i) {
        path[i] = at;
        const double along = speed * double(i) / plan.framesPerSecond;
        const double angle =
            heading + bend * along + 0.35 * std::sin(2 * kPi * along / (0.2 * edge));
        at += speed / plan.framesPerSecond * glm::dvec3(std::cos(angle), std::sin(angle), 0.0);
        const double margin = 0.03 * edge;
        at.x = std::clamp(at.x, box.low.x + margin, box.high.x - margin);
        at.y = std::clamp(at.y, box.low.y + margin, box.high.y - margin);
    }

    // Heights at most every twelve metres or so: a column costs thousands of samples.
    const double stride = std::max(1.0, edge / 1400 / (speed / plan.framesPerSecond));
    std::vector<double> ground;
    for (double frame = 0; frame < double(count); frame += stride) {
        const glm::dvec3& p = path[static_cast<std::size_t>(frame)];
        ground.push_back(land.ground(p.x, p.y));
    }
    const std::vector<double> above = smoothlyAbove(ground, 18);
    for (std::size_t i = 0; i < count; ++i) {
        const double place = std::min(double(i) / stride, double(above.size() - 1));
        const auto before = static_cast<std::size_t>(place);
        const std::size_t after = std::min(before + 1, above.size() - 1);
        const double share = place - double(before);
        path[i].z = land.clearance + above[before] + share * (above[after] - above[before]);
    }

    std::vector<hierarchy::View> views;
    for (std::size_t i = 0; i < plan.frames; ++i) {
        const std::size_t ahead = std::min(i + 20, count - 1);
        glm::dvec3 forward = path[ahead] - path[i];
        if (glm::length(glm::dvec2(forward)) == 0) // too slow to see which way it goes
            forward = towards;
        forward.z = 0.5 * forward.z - 0.14 * glm::length(glm::dvec2(forward));
        views.push_back(
            viewTo(path[i], path[i] + forward, plan.fovDegrees, plan.width, plan.height));
    }
    return views;
}

std::vector<hierarchy::View> overTerrain(const Source& source, const FlightPlan& plan)
{
    const core::Box& box = source.worldBox;
    Land land;
    land.box = box;
    // Of a large raster a part is flown over, as from a small aircraft.
    land.edge =
        source.elevation ? std::min({box.size().x, box.size().y, kMostLand}) : source.domain.edge;
    land.eye = source.eye;
    land.towards = source.target - source.eye;
    land.clearance = land.edge / kClearances;
    // As many steps for any box: 4 m for one of 16 km.
    const double step = source.isProcedural ? box.size().z / 4096 : 4.0;
    // Where there is no ground, as between islands that float, one flies on as high as one began.
    const double level = source.eye.z - land.clearance;
    land.ground = [&source, &box, step, level](double x, double y) {
        const double height = fields::surfaceHeight(*source.field, box, x, y, step);
        return height > box.low.z ? height : level;
    };
    return overLand(land, plan);
}

core::Result<std::vector<hierarchy::View>>
overVoxels(const ShownModel& model, const FlightPlan& plan)
{
    const core::Box& box = model.box;
    const voxels::VoxelLattice& lattice = model.store->model().lattice;
    const glm::dvec3 size = box.size();
    Land land;
    land.box = box;
    land.edge = std::max(size.x, size.y);
    land.eye = {box.low.x + 0.2 * size.x, box.low.y + 0.2 * size.y, box.high.z};
    land.towards = {size.x, size.y, 0.0};
    // Voxels seen from too near are but blocks.
    land.clearance = std::max(land.edge / kClearances, kVoxelsBelow * lattice.edge);
    // Coarser levels lie above finer ones, by less than one of their voxels.
    std::uint32_t level = 0;
    while (level + 1 < lattice.levels &&
           std::ldexp(lattice.edge, static_cast<int>(level) + 1) < 0.25 * land.clearance)
        ++level;
    const auto caster =
        voxels::VoxelRayCaster::create(*model.store, voxels::cutOfLevel(*model.store, level));
    if (!caster)
        return tl::unexpected(caster.error());
    land.ground = [&](double x, double y) {
        const auto hit = caster->cast({.start = {x, y, box.high.z}, .direction = {0, 0, -1}});
        // a chunk that can't be read is told where it is shown
        return hit && *hit ? box.high.z - (*hit)->distance : box.low.z;
    };
    return overLand(land, plan);
}

/// What to go around, from where it fills the picture.
struct Orbit {
    glm::dvec3 eye;
    glm::dvec3 target;
    glm::dvec3 up;
};

std::vector<hierarchy::View> around(const Orbit& source, const FlightPlan& plan)
{
    const glm::dvec3 arm = source.eye - source.target;
    const glm::dvec3 rise = glm::dot(arm, source.up) * source.up;
    const double radius = glm::length(arm - rise);
    const double speed = plan.speed > 0 ? plan.speed : radius * kPi / 4; // a round in eight seconds
    std::vector<hierarchy::View> views;
    for (std::size_t i = 0; i < plan.frames; ++i) {
        const double along = speed * double(i) / plan.framesPerSecond;
        const double angle = along / std::max(radius, 1e-12);
        const double nearer = 1 - 0.45 * (0.5 - 0.5 * std::cos(angle));
        const glm::dvec3 out = arm - rise;
        const glm::dvec3 eye =
            source.target +
            nearer * (std::cos(angle) * out + std::sin(angle) * glm::cross(source.up, out) + rise);
        views.push_back(
            viewTo(eye, source.target, plan.fovDegrees, plan.width, plan.height, source.up));
    }
    return views;
}

} // namespace

std::vector<hierarchy::View> flightPath(const Source& source, const FlightPlan& plan)
{
    return source.isTerrain ? overTerrain(source, plan)
                            : around({source.eye, source.target, source.up}, plan);
}

core::Result<std::vector<hierarchy::View>>
flightPath(const ShownModel& model, const FlightPlan& plan)
{
    if (model.isLandscape && model.up == glm::dvec3(0, 0, 1))
        return overVoxels(model, plan);
    const glm::dvec3 target = model.box.centre();
    const glm::dvec3 eye = placeBefore(
        model.box, target, forwardTo(model), model.up, plan.fovDegrees, plan.width, plan.height);
    return around({eye, target, model.up}, plan);
}

} // namespace isofront::cli
