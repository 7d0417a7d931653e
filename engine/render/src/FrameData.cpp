#include "FrameData.h"

#include "Atmosphere.h"
#include "Samples.h"

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace isofront::render {

namespace {

// As in shaders/include/noise.glsl [m].
constexpr double kNoisePeriod = 4096.0;

glm::dmat3 worldFromGrid(const hierarchy::Domain& domain)
{
    return domain.worldFromField.linear * domain.gridUnit();
}

shared::vec4 row(const glm::dvec3& vector, double last = 0.0)
{
    return shared::vec4(glm::vec3(vector), static_cast<float>(last));
}

shared::uvec4 lowWords(const hierarchy::GridPoint& point)
{
    return {
        static_cast<std::uint32_t>(point.x),
        static_cast<std::uint32_t>(point.y),
        static_cast<std::uint32_t>(point.z),
        0};
}

shared::uvec4 highWords(const hierarchy::GridPoint& point)
{
    return lowWords({point.x >> 32, point.y >> 32, point.z >> 32});
}

double modulo(double value, double period)
{
    return value - period * std::floor(value / period);
}

/// What is added to a place along the box's axes, to come to its place in the map.
glm::dvec3 shadowOffsets(const SunBox& box, const glm::dvec3& scales)
{
    glm::dvec3 offsets(0.0, 0.0, 0.5);
    for (std::size_t i = 0; i < 3; ++i)
        offsets[i] -= box.centre[i] * scales[i];
    return offsets;
}

glm::dvec3 shadowScales(const SunBox& box)
{
    return {1.0 / box.halfWidth, 1.0 / box.halfWidth, 0.5 / box.halfDepth};
}

void setShadows(
    shared::Frame& frame,
    const SunBox& box,
    const glm::dmat3& gridFromDirection,
    int texels,
    double metres)
{
    const glm::dvec3 scales = shadowScales(box);
    const glm::dvec3 offsets = shadowOffsets(box, scales);
    for (std::size_t i = 0; i < 3; ++i) {
        frame.shadowFromWorld[i] = row(box.axes[i] * scales[i], offsets[i]);
        frame.shadowFromGrid[i] = row(gridFromDirection * box.axes[i] * scales[i], offsets[i]);
    }
    frame.shadowSize = shared::vec4(
        static_cast<float>(texels),
        static_cast<float>(2.0 * box.halfWidth / texels),
        1.0F,
        static_cast<float>(2.0 * box.halfDepth * metres));
}

void setSamples(shared::Frame& frame, int samples)
{
    float reach = 0;
    const std::span<const glm::ivec2> places = samplePlaces(samples);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const glm::vec2 fromMiddle = glm::vec2(places[i] - 8) / 16.0F;
        frame.samples[i] = shared::vec4(fromMiddle, 0.0F, 0.0F);
        reach = std::max({reach, std::abs(fromMiddle.x), std::abs(fromMiddle.y)});
    }
    frame.sampling = shared::vec4(static_cast<float>(samples), reach, 0.0F, 0.0F);
}

} // namespace

Camera cameraOf(const hierarchy::View& view)
{
    Camera camera;
    camera.forward = glm::normalize(view.forward);
    camera.right = glm::normalize(glm::cross(camera.forward, glm::normalize(view.up)));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.tangentY = std::tan(0.5 * view.verticalFieldOfView);
    camera.tangentX = camera.tangentY * view.width / view.height;
    return camera;
}

GridView gridView(const hierarchy::Domain& domain, const hierarchy::View& view)
{
    const Camera camera = cameraOf(view);
    GridView result;
    result.eye = domain.gridFromWorld(view.eye);
    result.worldFromGrid = worldFromGrid(domain);
    const std::array inWorld{
        camera.forward * camera.tangentX + camera.right,
        camera.forward * camera.tangentX - camera.right,
        camera.forward * camera.tangentY + camera.up,
        camera.forward * camera.tangentY - camera.up};
    for (std::size_t i = 0; i < inWorld.size(); ++i)
        result.sides[i] = glm::transpose(result.worldFromGrid) * inWorld[i];
    return result;
}

double defaultNearPlane(const hierarchy::Domain& domain)
{
    return std::ldexp(domain.edge * domain.worldFromField.stretch(), -24);
}

float shownWeight(const Scene& scene)
{
    return scene.transition < 1.0F ? std::max(scene.transition, 0.0F) : 1.0F;
}

shared::Frame frameData(
    const hierarchy::Domain& domain,
    const hierarchy::View& view,
    const Scene& scene,
    const SunBox& sunBox,
    int shadowTexels,
    int samples,
    const HandOver* handOver)
{
    const Camera camera = cameraOf(view);
    const glm::dmat3 linear = worldFromGrid(domain);
    const glm::dmat3 gridFromDirection = glm::transpose(linear);
    const double near = scene.nearPlane > 0 ? scene.nearPlane : defaultNearPlane(domain);
    const hierarchy::GridPoint eye = domain.gridFromWorld(view.eye);
    const glm::dvec3 up = glm::normalize(scene.up);
    const glm::dvec3 sun = glm::normalize(scene.sunDirection);
    const TerrainLook& terrain = scene.terrain;
    const double metres = 1.0 / terrain.metre;

    shared::Frame frame{};
    frame.clipX = row(gridFromDirection * camera.right / camera.tangentX, near);
    frame.clipY = row(gridFromDirection * camera.up / -camera.tangentY);
    frame.clipW = row(gridFromDirection * camera.forward);
    const glm::dmat3 normals = domain.worldFromField.normalMatrix();
    // Only the direction matters, so the largest column sets the scale.
    const double scale =
        std::max({glm::length(normals[0]), glm::length(normals[1]), glm::length(normals[2])});
    for (std::size_t i = 0; i < 3; ++i)
        frame.worldFromNormal[i] = row(normals[i] / scale);
    frame.eyeLow = lowWords(eye);
    frame.eyeHigh = highWords(eye);

    const double radiansAPixel = 2.0 * camera.tangentY / view.height;
    frame.rayForward = row(camera.forward, radiansAPixel);
    frame.rayRight = row(camera.right * camera.tangentX);
    frame.rayDown = row(camera.up * -camera.tangentY);
    frame.picture = shared::vec4(
        static_cast<float>(view.width),
        static_cast<float>(view.height),
        static_cast<float>(1.0 / view.width),
        static_cast<float>(1.0 / view.height));

    // From the domain's own corner, so that a scene looks the same wherever its domain lies.
    const glm::dvec3 fromCorner = linear * glm::dvec3(eye);
    const double cornerHeight = glm::dot(domain.worldFromField.point(domain.origin), up);
    const double height = glm::dot(fromCorner, up) + (cornerHeight - terrain.baseHeight);
    frame.eyePhase = shared::vec4(
        static_cast<float>(modulo(fromCorner.x * metres, kNoisePeriod)),
        static_cast<float>(modulo(fromCorner.y * metres, kNoisePeriod)),
        static_cast<float>(modulo(fromCorner.z * metres, kNoisePeriod)),
        static_cast<float>(height * metres));
    frame.up = row(up, metres);

    const Daylight day = daylight(glm::dot(sun, up), static_cast<double>(terrain.haze));
    frame.sunDirection = row(sun, static_cast<double>(scene.exposure));
    frame.sunLight = row(day.sunLight);
    frame.skyLight = row(day.skyLight);
    frame.groundLight = row(day.groundLight);
    constexpr double kHeightOfAir = 3000.0;
    // The air between the eye and a mountain is thicker than the sky's: it makes distance readable.
    constexpr double kAerialStrength = 2.0;
    frame.airScattering = row(day.airScattering, kHeightOfAir);
    frame.hazeScattering = row(day.hazeScattering, kAerialStrength);

    setSamples(frame, samples);
    if (sunBox.casts)
        setShadows(frame, sunBox, gridFromDirection, shadowTexels, metres);
    if (scene.backdrop)
        frame.backdrop = shared::vec4(*scene.backdrop, 1.0F);
    frame.heights = shared::vec4(
        terrain.grassLine, terrain.snowLine, terrain.layerThickness, terrain.finestDetail);
    if (scene.look == Look::terrain) {
        const std::array colours{
            terrain.rock, terrain.otherRock, terrain.grass, terrain.scree, terrain.snow};
        for (std::size_t i = 0; i < colours.size(); ++i)
            frame.colours[i] = shared::vec4(colours[i], 0.0F);
    } else {
        frame.colours[0] = shared::vec4(scene.studio.surface, 0.0F);
        frame.colours[1] = shared::vec4(scene.studio.cap, 0.0F);
    }
    frame.transition = shared::vec4(shownWeight(scene), 0.0F, 0.0F, 0.0F);
    if (handOver != nullptr) {
        const BlockGrid& grid = handOver->grid();
        const glm::dmat3 rows = glm::transpose(linear) / grid.edge;
        const glm::dvec3 at = (domain.worldFromGrid(eye) - grid.origin) / grid.edge;
        for (std::size_t axis = 0; axis < 3; ++axis)
            frame.blockFromGrid[axis] = row(rows[axis], at[axis]);
        frame.blockCount = {grid.count.x, grid.count.y, grid.count.z, grid.bits};
    }
    return frame;
}

void setFormerShadows(shared::Frame& frame, const SunBox* box)
{
    if (box != nullptr)
        frame.formerShadow = row(shadowOffsets(*box, shadowScales(*box)), 1.0);
}

} // namespace isofront::render
