#include "Models.h"
#include "Suites.h"

#include <isofront/bench/Timing.h>
#include <isofront/voxels/ChunkStreamer.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

constexpr int kWidth = 1280;
constexpr int kHeight = 720;
constexpr double kFieldOfView = 1.0;
/// Of the rays that tell what is visible; with fewer, small chunks are missed.
constexpr int kRaysAcross = 192;
constexpr int kRaysDown = 108;

struct Camera {
    glm::dvec3 eye{0.0};
    glm::dvec3 forward{0, 1, 0};

    [[nodiscard]] voxels::ChunkView view() const
    {
        return voxels::perspectiveView(
            eye, forward, {0, 0, 1}, kFieldOfView, kWidth, kHeight, 1e-4);
    }
};

struct Flight {
    const char* name;
    /// @param t  from 0 to 1
    Camera (*at)(double t);
};

Camera looking(const glm::dvec3& eye, const glm::dvec3& target)
{
    return {eye, target - eye};
}

const std::array<Flight, 3>& flights()
{
    static const std::array<Flight, 3> all{{
        {"zoom-in",
         [](double t) {
             const double distance = std::exp2(2 - 8 * t);
             return looking(
                 glm::dvec3(0.5, 0.5, 0.05) + distance * glm::dvec3(0.1, -0.8, 0.6),
                 {0.5, 0.5, 0.05});
         }},
        {"rotation",
         [](double t) {
             const double angle = 2 * std::numbers::pi * t;
             return looking(
                 {0.5 + 1.2 * std::cos(angle), 0.5 + 1.2 * std::sin(angle), 0.6}, {0.5, 0.5, 0.0});
         }},
        {"descent",
         [](double t) {
             const double height = 0.8 * (1 - t) * (1 - t) + 0.015;
             return looking({0.5, 0.05 + 0.2 * t, height}, {0.5, 0.8, 0.02});
         }},
    }};
    return all;
}

/// Which of a frame's draws a ray meets first, those that only test included: they, too, stand for
/// what is behind them.
core::Result<std::vector<std::uint32_t>> visibleOf(
    const voxels::ChunkStore& store,
    const voxels::ChunkFrame& frame,
    const Camera& camera,
    core::Jobs& jobs)
{
    voxels::ChunkCut cut;
    for (const voxels::ChunkDraw& draw : frame.draws)
        cut.push_back(draw.key);
    const auto caster = voxels::VoxelRayCaster::create(store, cut);
    if (!caster)
        return tl::unexpected(caster.error());
    const glm::dvec3 ahead = glm::normalize(camera.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
    const glm::dvec3 above = glm::cross(right, ahead);
    const double tangent = std::tan(0.5 * kFieldOfView);
    std::vector<voxels::Ray> rays;
    for (int y = 0; y < kRaysDown; ++y)
        for (int x = 0; x < kRaysAcross; ++x)
            rays.push_back(
                {camera.eye,
                 ahead + (2 * (x + 0.5) / kRaysAcross - 1) * tangent * kWidth / kHeight * right +
                     (1 - 2 * (y + 0.5) / kRaysDown) * tangent * above});
    const auto hits = caster->cast(rays, jobs);
    if (!hits)
        return tl::unexpected(hits.error());
    std::vector<voxels::ChunkKey> seen;
    for (const auto& hit : *hits)
        if (hit)
            seen.push_back(hit->chunk);
    std::ranges::sort(seen);
    std::vector<std::uint32_t> visible;
    for (const voxels::ChunkKey& key : cut)
        visible.push_back(std::ranges::binary_search(seen, key) ? 1 : 0);
    return visible;
}

} // namespace

SuiteResult runStreaming(const Context& context)
{
    SuiteResult result;
    Table table{
        "frames",
        "A city of houses: chunks and bytes of each frame",
        {{"flight", "", "zoom-in, rotation, or descent into the streets"},
         {"way", "", "no cap, a cap on uploads, or with what is hidden left out, too"},
         {"frame", "", "of the flight"},
         {"chunks", "", "drawn"},
         {"tests", "", "chunks that only test whether they are hidden"},
         {"voxels", "M", "in the chunks drawn or tested"},
         {"uploaded", "MiB", "for this frame"},
         {"resident", "MiB", "in the cache"},
         {"needed", "MiB", "by this view"},
         {"missing", "", "chunks that it needs and that aren't there yet"},
         {"update", "ms", "processor time for choosing chunks and places, without reading"}},
        {},
        {}};
    const auto plot = [&](const std::string& name, const char* what, const char* column) {
        Plot picture;
        picture.name = name + '-' + column;
        picture.title = name + ": " + what;
        picture.x = "frame";
        picture.y = column;
        picture.series = "way";
        picture.whereColumn = "flight";
        picture.whereWord = name;
        table.plots.push_back(picture);
    };
    for (const Flight& flight : flights()) {
        plot(flight.name, "uploads of each frame", "uploaded");
        plot(flight.name, "memory that the view needs", "needed");
        plot(flight.name, "voxels drawn or tested", "voxels");
    }

    constexpr double kMiB = 1024.0 * 1024.0;
    const auto resolution = context.pick<std::uint32_t>(700, 2000);
    const auto frames = context.pick<int>(24, 120);
    const std::uint64_t cap = std::uint64_t{context.pick<std::uint64_t>(2048, 8192)} << 10U;
    const auto made = inMemory(context, "city", city(24), resolution);
    if (!made) {
        result.check("the city is voxelised", false, made.error().message);
        return result;
    }
    const std::shared_ptr<voxels::ChunkStore>& store = *made;

    bool staysBelow = true;
    for (const Flight& flight : flights())
        for (const char* way : {"no cap", "cap", "cap, occlusion"}) {
            if (context.isStopped())
                return result;
            context.say(std::string(flight.name) + ", " + way);
            const std::string kind = way;
            voxels::StreamingSettings settings;
            settings.uploadBytes = kind == "no cap" ? settings.cacheBytes : cap;
            settings.hostBytes = settings.cacheBytes;
            settings.occlusion = kind == "cap, occlusion";
            const auto loading = std::make_shared<WaitingJobs>();
            auto streamer = voxels::ChunkStreamer::create(store, settings, loading);
            if (!streamer) {
                result.check("the city is streamed", false, streamer.error().message);
                return result;
            }
            std::vector<std::uint32_t> visible;
            for (int i = 1; i <= frames; ++i) {
                const Camera camera = flight.at(static_cast<double>(i - 1) / (frames - 1));
                const auto number = static_cast<std::uint64_t>(i);
                std::vector<voxels::Visibility> seen;
                if (i > 1 && settings.occlusion)
                    seen.push_back({number - 1, visible});
                const voxels::ChunkFrame* frame = nullptr;
                const Timing timing = timed(
                    [&] { frame = &(*streamer)->update(camera.view(), number, number - 1, seen); },
                    1);
                loading->wait();
                std::uint64_t drawn = 0;
                for (const voxels::ChunkDraw& draw : frame->draws)
                    drawn += draw.voxels;
                staysBelow = staysBelow && frame->uploadBytes <= settings.uploadBytes;
                table.add(
                    {std::string(flight.name),
                     kind,
                     count(i),
                     count(frame->opaque),
                     count(frame->draws.size() - frame->opaque),
                     static_cast<double>(drawn) * 1e-6,
                     static_cast<double>(frame->uploadBytes) / kMiB,
                     static_cast<double>(frame->residentBytes) / kMiB,
                     static_cast<double>(frame->wantedBytes) / kMiB,
                     count(frame->missing),
                     timing.least * 1e3});
                if (!settings.occlusion)
                    continue;
                auto known = visibleOf(*store, *frame, camera, *context.jobs);
                if (!known) {
                    result.check("rays are cast", false, known.error().message);
                    return result;
                }
                visible = std::move(*known);
            }
        }
    result.check(
        "No frame uploads more than the cap", staysBelow, std::to_string(cap >> 10U) + " KiB");
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench
