#include "EmbreeRays.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstddef>
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
    // Told to take one thread, Embree would allow TBB no more than one in the whole process.
    made->device = rtcNewDevice(nullptr);
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

void isofrontEmbreeCast(void* scene, std::span<EmbreeRay> rays)
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

void isofrontEmbreeCastPackets(void* scene, std::span<EmbreeRay> rays)
{
    RTCScene target = static_cast<Scene*>(scene)->scene;
    constexpr std::size_t kPacket = 16;
    for (std::size_t first = 0; first < rays.size(); first += kPacket) {
        const std::size_t count = std::min(kPacket, rays.size() - first);
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
        alignas(64) RTCRayHit16 hits{};
        alignas(64) std::array<int, kPacket> valid{};
        for (std::size_t i = 0; i < count; ++i) {
            const EmbreeRay& ray = rays[first + i];
            valid[i] = -1;
            hits.ray.org_x[i] = ray.start[0];
            hits.ray.org_y[i] = ray.start[1];
            hits.ray.org_z[i] = ray.start[2];
            hits.ray.dir_x[i] = ray.direction[0];
            hits.ray.dir_y[i] = ray.direction[1];
            hits.ray.dir_z[i] = ray.direction[2];
            hits.ray.tfar[i] = std::numeric_limits<float>::infinity();
            hits.ray.mask[i] = ~0U;
            hits.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid.data(), target, &context, &hits);
        for (std::size_t i = 0; i < count; ++i)
            rays[first + i].distance =
                hits.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID ? -1.0F : hits.ray.tfar[i];
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
