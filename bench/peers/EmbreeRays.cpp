#include "EmbreeRays.h"

#include <embree3/rtcore.h>

#include <atomic>
#include <cstring>
#include <limits>
#include <memory>

namespace {

using isofront::bench::peers::EmbreeRay;

struct Scene {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    std::atomic<std::int64_t> bytes = 0;

    ~Scene()
    {
        if (scene != nullptr)
            rtcReleaseScene(scene);
        if (device != nullptr)
            rtcReleaseDevice(device);
    }
};

bool countMemory(void* scene, ssize_t bytes, bool)
{
    static_cast<Scene*>(scene)->bytes += bytes;
    return true;
}

} // namespace

extern "C" {

void* isofrontEmbreeScene(
    const std::vector<float>& positions, const std::vector<std::array<std::uint32_t, 3>>& triangles)
{
    auto made = std::make_unique<Scene>();
    made->device = rtcNewDevice("threads=1");
    if (made->device == nullptr)
        return nullptr;
    rtcSetDeviceMemoryMonitorFunction(made->device, countMemory, made.get());
    made->scene = rtcNewScene(made->device);
    rtcSetSceneBuildQuality(made->scene, RTC_BUILD_QUALITY_HIGH);
    rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void* corners = rtcSetNewGeometryBuffer(
        geometry,
        RTC_BUFFER_TYPE_VERTEX,
        0,
        RTC_FORMAT_FLOAT3,
        3 * sizeof(float),
        positions.size() / 3);
    void* indices = rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles.size());
    if (corners == nullptr || indices == nullptr)
        return nullptr;
    std::memcpy(corners, positions.data(), positions.size() * sizeof(float));
    std::memcpy(indices, triangles.data(), triangles.size() * sizeof(triangles[0]));
    made->bytes = 0; // from here on, only the tree
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(made->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(made->scene);
    return made.release();
}

void isofrontEmbreeCast(void* scene, std::vector<EmbreeRay>& rays)
{
    RTCScene target = static_cast<Scene*>(scene)->scene;
    for (EmbreeRay& ray : rays) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRayHit hit{};
        hit.ray.org_x = ray.start[0];
        hit.ray.org_y = ray.start[1];
        hit.ray.org_z = ray.start[2];
        hit.ray.dir_x = ray.direction[0];
        hit.ray.dir_y = ray.direction[1];
        hit.ray.dir_z = ray.direction[2];
        hit.ray.tfar = std::numeric_limits<float>::infinity();
        hit.ray.mask = ~0U;
        hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(target, &context, &hit);
        ray.distance = hit.hit.geomID == RTC_INVALID_GEOMETRY_ID ? -1.0F : hit.ray.tfar;
    }
}

std::int64_t isofrontEmbreeMemory(void* scene)
{
    return static_cast<Scene*>(scene)->bytes;
}

void isofrontEmbreeClose(void* scene)
{
    delete static_cast<Scene*>(scene);
}

} // extern "C"
