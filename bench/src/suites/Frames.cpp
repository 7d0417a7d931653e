// What frames of flights through voxels cost: time, uploads and memory, as figures 13 and 14 and
// table 2 of Chajdas et al. have it.

#include "InstancedStore.h"
#include "Models.h"
#include "Suites.h"
#include "VoxelStudio.h"

#include <isofront/voxels/VoxelRay.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

namespace isofront::bench {

namespace {

constexpr double kMiB = 1024.0 * 1024.0;
/// As much as any of the flights needs, so that none is coarser than it asks for.
constexpr std::uint64_t kCacheBytes = 1ULL << 30U;
constexpr double kFieldOfView = 1.0;

/// What is flown past.
struct Exhibit {
    std::string name;
    std::shared_ptr<const voxels::ChunkStore> store;
    core::Box box;
    glm::dvec3 up{0, 0, 1};
    double voxelPixels = 1; ///< largest voxel that is asked for
};

struct Camera {
    glm::dvec3 eye{0.0};
    glm::dvec3 target{0.0};
};

struct Flight {
    std::string name;
    const Exhibit* exhibit = nullptr;
    /// @param t  from 0 to 1
    std::function<Camera(double t)> at;
    std::vector<std::pair<std::string, std::uint64_t>> caps; ///< on uploads; 0 for none [bytes]
};

/// [px]
struct PictureSize {
    int width = 0;
    int height = 0;
};

PictureSize sizeFor(const Context& context)
{
    return context.isFull() ? PictureSize{1280, 720} : PictureSize{240, 136};
}

/// A scan where there is one, or else hills.
core::Result<Exhibit> statue(const Context& context)
{
    Exhibit exhibit;
    voxels::TriangleModel model;
    if (auto dragon = context.isFull() ? modelFile(context, kDragon) : std::nullopt) {
        exhibit.name = "dragon";
        exhibit.up = {0, 1, 0};
        model = std::move(*dragon);
    } else {
        exhibit.name = "hills";
        model = hills(context.pick(60U, 600U));
    }
    exhibit.box = boundsOf(model);
    auto store = inMemory(context, exhibit.name, model, context.pick(300U, 4096U));
    if (!store)
        return tl::unexpected(store.error());
    exhibit.store = std::move(*store);
    return exhibit;
}

/// A city of instanced blocks: one of them in memory.
core::Result<Exhibit> metropolis(const Context& context)
{
    Exhibit exhibit;
    exhibit.name = "city";
    auto block = inMemory(context, "a block of the city", city(4, 0.5), context.pick(256U, 2048U));
    if (!block)
        return tl::unexpected(block.error());
    auto store = InstancedStore::create(std::move(*block), context.pick(2U, 4U));
    if (!store)
        return tl::unexpected(store.error());
    exhibit.store = std::move(*store);
    const auto box = voxels::worldBox(*exhibit.store);
    if (!box)
        return tl::unexpected(box.error());
    exhibit.box = *box;
    exhibit.voxelPixels = 2; // or it would be 13 million voxels a frame
    return exhibit;
}

/// From afar to where voxels of the finest level are as large as asked for.
core::Result<Flight> zoomIn(const Exhibit& statue, const PictureSize& size)
{
    const double diagonal = glm::length(statue.box.size());
    const glm::dvec3 forward =
        statue.up.y > 0.5 ? glm::dvec3(-0.3, -0.35, -1) : glm::dvec3(0.3, 1, -0.35);
    const glm::dvec3 back = -glm::normalize(forward);
    const auto caster = voxels::VoxelRayCaster::create(
        *statue.store, voxels::cutOfLevel(*statue.store, statue.store->model().lattice.levels - 1));
    if (!caster)
        return tl::unexpected(caster.error());
    const glm::dvec3 start = statue.box.centre() + 1.5 * diagonal * back;
    const auto hit = caster->cast({.start = start, .direction = -back});
    if (!hit)
        return tl::unexpected(hit.error());
    const glm::dvec3 target =
        *hit ? start - (*hit)->distance * back : glm::dvec3(statue.box.centre());
    hierarchy::View view;
    view.verticalFieldOfView = kFieldOfView;
    view.height = size.height;
    const double nearest =
        statue.store->model().lattice.edge * view.pixelsPerUnit() / statue.voxelPixels;
    const double farthest = 1.5 * diagonal;
    return Flight{
        statue.name + ", zoom-in",
        &statue,
        [=](double t) {
            return Camera{target + farthest * std::pow(nearest / farthest, t) * back, target};
        },
        {{"no cap", 0}}};
}

Flight rotation(const Exhibit& statue)
{
    const glm::dvec3 centre = statue.box.centre();
    const double radius = 1.1 * glm::length(statue.box.size());
    const glm::dvec3 up = statue.up;
    const glm::dvec3 side(1, 0, 0);
    const glm::dvec3 front = glm::cross(up, side);
    return Flight{
        statue.name + ", rotation",
        &statue,
        [=](double t) {
            const double angle = 2 * std::numbers::pi * t;
            return Camera{
                centre + radius * (std::cos(angle) * side + std::sin(angle) * front + 0.2 * up),
                centre};
        },
        {{"no cap", 0}}};
}

/// From above the city down into one of its streets.
Flight descent(const Exhibit& city, std::uint64_t cap)
{
    const glm::dvec3 low = city.box.low;
    const glm::dvec3 size = city.box.size();
    return Flight{
        city.name + ", descent",
        &city,
        [=](double t) {
            const double height = size.z * (0.15 + 6 * (1 - t) * (1 - t));
            const glm::dvec3 eye =
                low + glm::dvec3(0.5 * size.x, (0.1 + 0.35 * t) * size.y, height);
            const glm::dvec3 target =
                low + glm::dvec3(0.5 * size.x, (0.5 + 0.4 * t) * size.y, 0.1 * size.z);
            return Camera{eye, target};
        },
        {{"no cap", 0}, {std::to_string(cap >> 10U) + " KiB a frame", cap}}};
}

Table frameTable(const std::vector<Flight>& flights)
{
    Table table{
        "frames",
        "Frames of flights past voxels",
        {{"flight", "", "what is flown past, and how"},
         {"cap", "", "on uploads"},
         {"frame", "", "frame of the flight"},
         {"time", "ms", "by the clock, from choosing chunks to the finished picture"},
         {"cpu", "ms", "processor time of it, all threads, those of a driver in software too"},
         {"gpu", "ms", "of its passes by the device's clock"},
         {"chunks", "", "drawn"},
         {"tests", "", "chunks that only test whether they are hidden"},
         {"voxels", "M", "drawn"},
         {"uploaded", "MiB", "uploaded for this frame"},
         {"needed", "MiB", "memory that this view needs"},
         {"resident", "MiB", "memory of the chunks in the cache"},
         {"share", "%", "of the model that this view needs"},
         {"missing", "", "chunks that it needs and that aren't there yet"}},
        {},
        {}};
    for (const Flight& flight : flights)
        for (const auto& [column, what] :
             {std::pair{"time", "time of each frame"},
              std::pair{"uploaded", "uploads of each frame"},
              std::pair{"needed", "memory that each frame needs"},
              std::pair{"resident", "memory in the cache"}}) {
            Plot plot;
            plot.name = flight.name;
            std::ranges::replace(plot.name, ',', '-');
            std::erase(plot.name, ' ');
            plot.name += std::string("-") + column;
            plot.title = flight.name + ": " + what;
            plot.x = "frame";
            plot.y = column;
            plot.series = "cap";
            plot.whereColumn = "flight";
            plot.whereWord = flight.name;
            table.plots.push_back(std::move(plot));
        }
    return table;
}

Table flightTable()
{
    return {
        "flights",
        "The same flights in short",
        {{"flight", "", ""},
         {"cap", "", "on uploads"},
         {"frames", "", ""},
         {"model", "MiB", "voxels of all levels, without colours"},
         {"time", "ms", "of a frame, the median"},
         {"most_time", "ms", "of a frame"},
         {"cpu", "ms", "processor time of a frame, the median"},
         {"first_upload", "MiB", "in the first frame with any"},
         {"most_upload", "MiB", "in a frame"},
         {"later_upload", "KiB", "in a frame after the first tenth, the mean"},
         {"all_upload", "MiB", "in all frames"},
         {"needed", "MiB", "by a frame, the mean"},
         {"most_needed", "MiB", "by a frame"},
         {"share", "%", "of the model that a frame needs, the mean"},
         {"voxels", "M", "drawn for a frame, the mean"}},
        {},
        {}};
}

double medianOf(std::vector<double> values)
{
    if (values.empty())
        return 0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return *middle;
}

double mebibytes(std::uint64_t bytes)
{
    return static_cast<double>(bytes) / kMiB;
}

/// A flight in short, and what must hold of it.
void enter(
    const Flight& flight,
    const std::pair<std::string, std::uint64_t>& cap,
    std::uint64_t modelBytes,
    const std::vector<StudioFrame>& all,
    Table& flights,
    SuiteResult& result)
{
    std::vector<double> walls;
    std::vector<double> cpus;
    std::uint64_t uploaded = 0;
    std::uint64_t later = 0;
    std::uint64_t first = 0;
    std::uint64_t most = 0;
    std::uint64_t needed = 0;
    std::uint64_t mostNeeded = 0;
    std::uint64_t voxelSum = 0;
    double coarsening = 1;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const StudioFrame& frame = all[i];
        walls.push_back(1e3 * frame.wall);
        cpus.push_back(1e3 * frame.cpu);
        if (first == 0)
            first = frame.uploadBytes;
        uploaded += frame.uploadBytes;
        later += 10 * i >= all.size() ? frame.uploadBytes : 0;
        most = std::max(most, frame.uploadBytes);
        needed += frame.wantedBytes;
        mostNeeded = std::max(mostNeeded, frame.wantedBytes);
        voxelSum += frame.voxels;
        coarsening = std::max(coarsening, frame.coarsening);
    }
    const auto number = static_cast<double>(all.size());
    flights.add(
        {flight.name,
         cap.first,
         bench::count(all.size()),
         mebibytes(modelBytes),
         medianOf(walls),
         *std::ranges::max_element(walls),
         medianOf(cpus),
         mebibytes(first),
         mebibytes(most),
         1024 * mebibytes(later) / (0.9 * number),
         mebibytes(uploaded),
         mebibytes(needed) / number,
         mebibytes(mostNeeded),
         100 * static_cast<double>(needed) / number / static_cast<double>(modelBytes),
         1e-6 * static_cast<double>(voxelSum) / number});
    if (cap.second != 0)
        result.check(
            flight.name + ": no frame uploads more than " + cap.first,
            most <= cap.second,
            std::to_string(most) + " bytes");
    result.check(
        flight.name + ", " + cap.first + ": what is needed fits the cache",
        coarsening == 1,
        "voxels are " + std::to_string(coarsening) + " times as large as asked for");
}

/// Flies once, and enters each frame and the sum.
core::Result<void>
fly(const Context& context,
    const Flight& flight,
    const std::pair<std::string, std::uint64_t>& cap,
    Table& frames,
    Table& flights,
    SuiteResult& result)
{
    const PictureSize size = sizeFor(context);
    const Exhibit& exhibit = *flight.exhibit;
    const std::uint64_t modelBytes = bytesOf(*exhibit.store);
    auto studio = VoxelStudio::create(
        exhibit.store,
        {.width = size.width,
         .height = size.height,
         .up = exhibit.up,
         .streaming = {.voxelPixels = exhibit.voxelPixels},
         .poolBytes = kCacheBytes,
         .uploadBytes = cap.second});
    if (!studio)
        return tl::unexpected(studio.error());
    const int count = context.pick(6, 60);
    result.notes = {"drawn by " + (*studio)->deviceName()};
    std::vector<StudioFrame> all;
    for (int i = 0; i < count && !context.isStopped(); ++i) {
        if (i % 10 == 0)
            context.say(
                flight.name + ", " + cap.first + ", frame " + std::to_string(i) + " of " +
                std::to_string(count));
        const Camera camera = flight.at(static_cast<double>(i) / (count - 1));
        const auto frame =
            (*studio)->next((*studio)->view(camera.eye, camera.target, kFieldOfView));
        if (!frame)
            return tl::unexpected(frame.error());
        all.push_back(*frame);
        frames.add(
            {flight.name,
             cap.first,
             bench::count(i + 1),
             1e3 * frame->wall,
             1e3 * frame->cpu,
             1e3 * frame->gpu,
             bench::count(frame->chunks),
             bench::count(frame->tests),
             1e-6 * static_cast<double>(frame->voxels),
             mebibytes(frame->uploadBytes),
             mebibytes(frame->wantedBytes),
             mebibytes(frame->residentBytes),
             100 * static_cast<double>(frame->wantedBytes) / static_cast<double>(modelBytes),
             bench::count(frame->missing)});
    }
    if (context.isStopped())
        return {};
    enter(flight, cap, modelBytes, all, flights, result);
    return {};
}

/// The same picture with more and more samples a pixel: table 2 of Chajdas et al.
core::Result<Table> smoothedPictures(const Context& context, const Exhibit& exhibit)
{
    Table table{
        "antialiasing",
        "A picture with more samples a pixel",
        {{"samples", "", "of each pixel; or steps softened afterwards"},
         {"time", "ms", "by the clock, the least of the runs"},
         {"cpu", "ms", "processor time of it, all threads, the least of the runs"},
         {"ratio", "", "of processor time, to one sample"},
         {"gpu", "ms", "of its passes by the device's clock, the least of the runs"}},
        {},
        {}};
    const PictureSize size = sizeFor(context);
    double alone = 0;
    const Camera camera = rotation(exhibit).at(0.1);
    for (const auto& [name, samples, isSoftened] :
         {std::tuple{"1", 1, false},
          std::tuple{"1, softened", 1, true},
          std::tuple{"4", 4, false},
          std::tuple{"8", 8, false}}) {
        if (context.isStopped())
            break;
        context.say(std::string("samples a pixel: ") + name);
        auto studio = VoxelStudio::create(
            exhibit.store,
            {.width = size.width,
             .height = size.height,
             .up = exhibit.up,
             .streaming = {.voxelPixels = exhibit.voxelPixels},
             .antialias = isSoftened,
             .samples = samples});
        if (!studio && samples > 1 && studio.error().code == core::ErrorCode::noDevice) {
            constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
            table.add({std::string(name) + ", not on this device", kNone, kNone, kNone, kNone});
            continue;
        }
        if (!studio)
            return tl::unexpected(studio.error());
        const hierarchy::View view = (*studio)->view(camera.eye, camera.target, kFieldOfView);
        auto least = (*studio)->settle(view);
        for (int i = 0; least && i < context.pick(1, 9); ++i) {
            const auto frame = (*studio)->next(view);
            if (!frame)
                return tl::unexpected(frame.error());
            least->wall = std::min(least->wall, frame->wall);
            least->cpu = std::min(least->cpu, frame->cpu);
            least->gpu = std::min(least->gpu, frame->gpu);
        }
        if (!least)
            return tl::unexpected(least.error());
        if (alone == 0)
            alone = least->cpu;
        table.add(
            {std::string(name),
             1e3 * least->wall,
             1e3 * least->cpu,
             least->cpu / alone,
             1e3 * least->gpu});
    }
    return table;
}

} // namespace

SuiteResult runFrames(const Context& context)
{
    SuiteResult result;
    const auto fail = [&](const core::Error& error) {
        noteUndrawn(result, context, error);
        return result;
    };
    const auto statueOrNot = statue(context);
    if (!statueOrNot)
        return fail(statueOrNot.error());
    const auto cityOrNot = metropolis(context);
    if (!cityOrNot)
        return fail(cityOrNot.error());
    const auto zoom = zoomIn(*statueOrNot, sizeFor(context));
    if (!zoom)
        return fail(zoom.error());
    const std::vector<Flight> all{
        *zoom,
        rotation(*statueOrNot),
        descent(*cityOrNot, context.pick<std::uint64_t>(512U << 10U, 1U << 20U))};
    Table frames = frameTable(all);
    Table flights = flightTable();
    for (const Flight& flight : all)
        for (const auto& cap : flight.caps)
            if (const auto flown = fly(context, flight, cap, frames, flights, result);
                !flown || context.isStopped())
                return flown ? result : fail(flown.error());
    auto smoothed = smoothedPictures(context, *statueOrNot);
    if (!smoothed)
        return fail(smoothed.error());
    result.tables = {std::move(flights), std::move(*smoothed), std::move(frames)};
    return result;
}

} // namespace isofront::bench
