#include "Arguments.h"
#include "Console.h"
#include "FlightStage.h"
#include "FlyArguments.h"
#include "ModelView.h"
#include "OutputFolder.h"
#include "report/FlightReport.h"
#include "report/Popping.h"

#include <isofront/core/Process.h>
#include <isofront/exchange/ContactSheet.h>
#include <isofront/exchange/Png.h>
#include <isofront/exchange/Video.h>
#include <isofront/render/HybridScene.h>

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <system_error>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kSheetPictures = 12;
constexpr int kSheetColumns = 4;
constexpr int kSheetThumbnail = 480; // [px]

double millisecondsSince(Clock::time_point start)
{
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Memory that the process holds now [bytes]; 0 where the system doesn't tell.
std::uint64_t residentBytes()
{
    std::uint64_t pages = 0;
    std::uint64_t resident = 0;
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
        std::fopen("/proc/self/statm", "r"), std::fclose);
    if (!file || std::fscanf(file.get(), "%lu %lu", &pages, &resident) != 2)
        return 0;
    return resident * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

/// One flight: what it flies with, and what it has recorded.
class Flying {
public:
    Flying(const FlyArguments& arguments, Progress& progress)
        : _arguments(arguments), _progress(progress), _stop(interruptions())
    {
    }

    int run()
    {
        if (const auto error = prepare())
            return report(*error);
        std::optional<core::Error> error = takeOff();
        for (std::size_t i = 0; !error && i < _stage->views.size() && !_stop.stop_requested();
             ++i) {
            _progress.show(
                "frame " + std::to_string(i + 1) + " of " + std::to_string(_stage->views.size()),
                double(i) / double(_stage->views.size()));
            error = frame(i);
        }
        // What was flown is kept, even if the flight ended early.
        const std::optional<core::Error> unwritten = land();
        _progress.finish();
        if (error)
            return report(*error);
        if (_report.frames.empty())
            return report(
                {ErrorCode::interrupted,
                 "interrupted before the first frame; nothing was written"});
        if (unwritten)
            return report(*unwritten);
        tell();
        if (_stop.stop_requested())
            return report(
                {ErrorCode::interrupted,
                 "interrupted after " + std::to_string(_report.frames.size()) +
                     " frames; what was flown is in " + _arguments.out});
        return 0;
    }

private:
    using MaybeError = std::optional<core::Error>;

    MaybeError prepare()
    {
        if (auto made = _folder.make(_arguments.out); !made)
            return made.error();
        auto stage = stageOf(_arguments, _progress, _stop);
        if (!stage)
            return stage.error();
        _stage.emplace(std::move(*stage));
        _report.settings = _stage->settings;
        return openVideo();
    }

    MaybeError openVideo()
    {
        if (!exchange::VideoWriter::available()) {
            _progress.say("note: there is no ffmpeg, so frames are written as PNG files");
            return std::nullopt;
        }
        auto video = exchange::VideoWriter::open(
            inFolder("flight.mp4"),
            {.width = _report.settings.width,
             .height = _report.settings.height,
             .framesPerSecond = kFramesPerSecond});
        if (!video)
            return video.error();
        _video.emplace(std::move(*video));
        return std::nullopt;
    }

    /// The surface for the first view, whole, and a first picture that nobody sees: shaders are
    /// compiled at their first use.
    MaybeError takeOff()
    {
        if (!_stage->surface)
            _progress.show("loading " + _arguments.source, -1);
        const auto settled = _stage->scene->settle(
            _stage->views.front(),
            _stage->studio.scene,
            [&](double share) { _progress.show("first surface", share); },
            _stop);
        if (!settled && settled.error().code == ErrorCode::interrupted)
            return std::nullopt; // nothing is flown, and that is told
        if (!settled)
            return tooLarge(settled.error());
        tellDamage(settled->damaged);
        noteSource(*settled);
        if (auto drawn = _stage->scene->frame(_stage->views.front(), _stage->studio.scene, -1.0);
            !drawn)
            return drawn.error();
        if (auto done = _stage->studio.renderer->finish(); !done)
            return done.error();
        if (_stage->surface)
            _before = _stage->surface->stats();
        return std::nullopt;
    }

    MaybeError frame(std::size_t number)
    {
        const hierarchy::View& view = _stage->views[number];
        const double time = double(number) / kFramesPerSecond;
        if (const auto error = drawUnchanged(view))
            return error;
        const auto start = Clock::now();
        const auto drawn = _stage->scene->frame(view, _stage->studio.scene, time);
        if (!drawn)
            return tooLarge(drawn.error());
        tellDamage(drawn->damaged);
        noteSource(*drawn);
        FrameRecord record;
        record.updateMilliseconds = drawn->surfaceMilliseconds;
        record.cpuMilliseconds = millisecondsSince(start);
        const auto passes = _stage->studio.renderer->finish();
        if (!passes)
            return passes.error();
        for (const render::PassTime& pass : *passes)
            record.gpuMilliseconds += pass.milliseconds;

        record.time = time;
        record.triangles = drawn->drawn.triangles;
        record.draws = drawn->drawn.draws;
        record.cellsFading = drawn->drawn.cellsFading;
        record.fadingBytes = drawn->drawn.fadingBytes;
        record.uploadedBytes = drawn->meshes.uploadedBytes + drawn->uploadedVoxelBytes;
        record.deviceBytes = drawn->drawn.deviceBytes;
        record.voxels = drawn->drawn.voxels.voxels;
        record.voxelChunks = drawn->drawn.voxels.chunksDrawn;
        record.missingChunks = drawn->missingChunks;
        record.voxelBytes = drawn->residentVoxelBytes;
        record.meshBlocks = drawn->meshBlocks;
        record.voxelBlocks = drawn->voxelBlocks;
        record.effectiveVoxelPixels = drawn->voxelPixels;
        record.residentBytes = residentBytes();
        record.meshBytes = record.sourceBytes = drawn->sourceBytes;
        record.sourceHostBytes = drawn->sourceHostBytes;
        record.eye = view.eye;
        if (_stage->surface)
            recordSurface(record);
        _report.frames.push_back(record);
        return keepPicture(number);
    }

    void recordSurface(FrameRecord& record)
    {
        const surface::SurfaceStats stats = _stage->surface->stats();
        record.shownCells = stats.shownCells;
        record.cellsExtracted = stats.cellsExtracted - _before.cellsExtracted;
        record.cellsSkipped = stats.cellsSkipped - _before.cellsSkipped;
        record.cellsFromCache = stats.cellsFromCache - _before.cellsFromCache;
        record.cellsPending = stats.pendingCells;
        record.effectivePixelError = stats.effectivePixelError;
        record.meshBytes = stats.meshBytes;
        record.cacheBytes = stats.cacheBytes;
        _before = stats;
    }

    /// For measuring: the view as it would be if nothing of the mesh changed.
    MaybeError drawUnchanged(const hierarchy::View& view)
    {
        if (!_arguments.measurePopping)
            return std::nullopt;
        if (const auto drawn = _stage->scene->redraw(view, _stage->studio.scene); !drawn)
            return drawn.error();
        auto image = _stage->studio.renderer->readImage();
        if (!image)
            return image.error();
        _unchanged = std::move(*image);
        return std::nullopt;
    }

    MaybeError keepPicture(std::size_t number)
    {
        const auto image = _stage->studio.renderer->readImage();
        if (!image)
            return image.error();
        if (_arguments.measurePopping) {
            const Popping popping = poppingBetween(_unchanged, *image);
            _report.frames.back().largestPop = popping.largest;
            _report.frames.back().meanPop = popping.mean;
        }
        const std::size_t every = std::max<std::size_t>(1, _stage->views.size() / kSheetPictures);
        if (number % every == every / 2 && _sheet.size() < kSheetPictures)
            _sheet.push_back(*image);
        if (_video) {
            if (auto added = _video->add(*image); !added)
                return added.error();
            return std::nullopt;
        }
        std::array<char, 32> name{};
        std::snprintf(name.data(), name.size(), "frame-%05zu.png", number);
        if (auto written = exchange::writePng(*image, inFolder(name.data())); !written)
            return written.error();
        return std::nullopt;
    }

    MaybeError land()
    {
        if (_report.frames.empty())
            return std::nullopt;
        _progress.show("writing the report", -1);
        if (_video) {
            if (auto finished = _video->finish(); !finished)
                return finished.error();
            _report.video = "flight.mp4";
        }
        if (!_sheet.empty()) {
            const core::Image sheet =
                exchange::contactSheet(_sheet, kSheetColumns, kSheetThumbnail);
            if (auto written = exchange::writePng(sheet, inFolder("contact-sheet.png")); !written)
                return written.error();
            _report.contactSheet = "contact-sheet.png";
        }
        if (auto written = writeReportJson(_report, inFolder("report.json")); !written)
            return written.error();
        if (auto written = writeReportHtml(_report, inFolder("report.html")); !written)
            return written.error();
        return std::nullopt;
    }

    void tell()
    {
        const FlightSummary summary = summarised(_report.frames);
        if (_arguments.json) {
            nlohmann::ordered_json json;
            json["out"] = _arguments.out;
            json["frames"] = _report.frames.size();
            json["report"] = inFolder("report.json");
            json["page"] = inFolder("report.html");
            json["video"] = _video ? nlohmann::ordered_json(inFolder("flight.mp4")) : nullptr;
            json["contact_sheet"] =
                _sheet.empty() ? nullptr : nlohmann::ordered_json(inFolder("contact-sheet.png"));
            const auto spread = [](const Spread& s) {
                return nlohmann::ordered_json{
                    {"p50", s.p50}, {"p95", s.p95}, {"p99", s.p99}, {"max", s.max}};
            };
            json["cpu_milliseconds"] = spread(summary.cpuMilliseconds);
            json["gpu_milliseconds"] = spread(summary.gpuMilliseconds);
            json["effective_pixel_error_max"] = summary.maxEffectivePixelError;
            json["mean_triangles"] = summary.meanTriangles;
            json["cells_extracted"] = summary.cellsExtracted;
            json["cells_skipped"] = summary.cellsSkipped;
            json["cells_from_cache"] = summary.cellsFromCache;
            json["mean_voxels"] = summary.meanVoxels;
            json["effective_voxel_pixels_max"] = summary.maxEffectiveVoxelPixels;
            json["chunks_damaged"] = _damaged;
            json["source"] = sourceJson(summary);
            print(json);
            return;
        }
        std::array<char, 200> line{};
        std::snprintf(
            line.data(),
            line.size(),
            "%zu frames, %.0f %s each; median %.1f ms on the processor, %.1f ms on %s",
            _report.frames.size(),
            _stage->surface ? summary.meanTriangles : summary.meanVoxels,
            _stage->surface ? "triangles" : "voxels",
            summary.cpuMilliseconds.p50,
            summary.gpuMilliseconds.p50,
            _report.settings.device.c_str());
        _progress.say(line.data());
        if (const std::string note =
                coarserNote(_arguments.pixelError, summary.maxEffectivePixelError);
            !note.empty())
            _progress.say(note);
        if (const std::string note = coarserVoxelsNote(
                _stage->voxelPixels, summary.maxEffectiveVoxelPixels, _stage->cacheBytes);
            !note.empty())
            _progress.say(note);
        for (const std::filesystem::path& name :
             {_report.video,
              _report.contactSheet,
              std::filesystem::path("report.html"),
              std::filesystem::path("report.json")})
            if (!name.empty())
                _progress.say("  " + inFolder(name.string()));
    }

    void tellDamage(const std::vector<core::Error>& damaged)
    {
        _damaged += damaged.size();
        for (const core::Error& error : damaged)
            _progress.say("warning: " + error.message + "; coarser voxels are shown in its place");
    }

    /// What is to be said of the model's source is said once.
    void noteSource(const render::HybridFrame& frame)
    {
        _sourceIsFull = _sourceIsFull || frame.sourceIsFull;
        if (frame.sourceError)
            _sourceError = frame.sourceError->message;
        const std::string note = _hasToldSource ? std::string() : sourceNote(frame);
        _hasToldSource = _hasToldSource || !note.empty();
        if (!note.empty())
            _progress.say(note);
    }

    /// Like that of a picture, of the whole flight.
    [[nodiscard]] nlohmann::ordered_json sourceJson(const FlightSummary& summary) const
    {
        if (!_stage->sourceFile)
            return nullptr;
        nlohmann::ordered_json json;
        json["file"] = _stage->sourceFile->string();
        json["bytes_max"] = summary.maxSourceBytes;
        json["host_bytes_max"] = summary.maxSourceHostBytes;
        json["is_full"] = _sourceIsFull;
        json["error"] = _sourceError ? nlohmann::ordered_json(*_sourceError) : nullptr;
        return json;
    }

    [[nodiscard]] core::Error tooLarge(const core::Error& error) const
    {
        if (error.code != ErrorCode::resourceLimit || !_stage->surface)
            return error;
        return error.within("the meshes don't fit on the device; choose a larger --pixel-error");
    }

    [[nodiscard]] std::string inFolder(const std::string& name) const
    {
        return (std::filesystem::path(_arguments.out) / name).string();
    }

    const FlyArguments& _arguments;
    Progress& _progress;
    std::stop_token _stop;
    core::Image _unchanged; ///< the frame's view, before its changes
    OutputFolder _folder;
    std::optional<FlightStage> _stage;
    std::optional<exchange::VideoWriter> _video;
    std::vector<core::Image> _sheet;
    surface::SurfaceStats _before;
    std::size_t _damaged = 0; ///< chunks that couldn't be read
    bool _hasToldSource = false;
    bool _sourceIsFull = false; ///< not all that a view needed of it had room
    std::optional<std::string> _sourceError;
    FlightReport _report;
};

int fly(const FlyArguments& arguments)
{
    Progress progress(arguments.quiet);
    return Flying(arguments, progress).run();
}

} // namespace

Action addFly(CLI::App& app)
{
    auto arguments = std::make_shared<FlyArguments>();
    CLI::App* command = app.add_subcommand(
        "fly", "Fly over a terrain or around a source: a video, a contact sheet and a report");
    arguments->command = command;
    addSource(*command, arguments->source);
    command->add_option("--preset", arguments->preset, "terrain: see 'isofront info proc:'")
        ->capture_default_str();
    command->add_option("--seed", arguments->seed, "of the terrain")->capture_default_str();
    command->add_option("--isovalue", arguments->isovalue, "of a volume")->check(isovalues());
    command->add_option("--frames", arguments->frames, "30 a second")
        ->check(CLI::Range(1, 1000000))
        ->capture_default_str();
    command->add_option("--speed", arguments->speed, "[world units/s]; 0 chooses")
        ->check(within(0.0, 1e9))
        ->capture_default_str();
    command->add_option("--fov", arguments->fov, "vertical field of view [degrees]")
        ->check(within(1.0, 179.0))
        ->capture_default_str();
    command->add_option("--size", arguments->size, "[px]")->capture_default_str();
    addSamples(*command, arguments->samples);
    command->add_option("--pixel-error", arguments->pixelError, "expected error of the mesh [px]")
        ->capture_default_str();
    command
        ->add_option(
            "--update-ms", arguments->updateMilliseconds, "of a frame for the surface [ms]")
        ->check(within(0.1, 1000.0))
        ->capture_default_str();
    command->add_option("--fade", arguments->fade, "how long a change of detail takes to show [s]")
        ->check(within(0.0, 10.0))
        ->capture_default_str();
    command->add_flag(
        "--measure-popping", arguments->measurePopping, "report how much changes of detail show");
    arguments->far.addTo(*command);
    addVoxelOptions(*command, arguments->voxelPixels, arguments->way, arguments->up);
    arguments->sourceChoice.addTo(*command);
    addCacheOption(*command, arguments->cacheMib, "");
    command->add_option("--lattice", arguments->lattice, "lattice segments of a cell: 4, 8 or 16")
        ->capture_default_str();
    command->add_option("--filter", arguments->filter, "strength of the low-pass filter")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    arguments->detail.addDetailTo(*command);
    arguments->detail.addCeilingsTo(*command);
    arguments->mesh.addTo(*command);
    command->add_option("--out", arguments->out, "folder for what is made")->capture_default_str();
    command->add_option(
        "--device",
        arguments->device,
        "Vulkan device: an index, 'cpu', 'gpu' or part of its name; also ISOFRONT_DEVICE");
    command->add_option("--threads", arguments->threads, "of the extraction; 0: one for each core")
        ->check(CLI::Range(0, 1024));
    arguments->input.detail = "natural";
    addSourceArguments(*command, arguments->input);
    command->add_flag("--window", arguments->window, "not in this version");
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer(
        "A SOURCE stands in for --preset and --seed; landscapes are flown over, all else, "
        "models that 'isofront voxelize' made among it, around.\n\n"
        "Examples:\n"
        "  isofront fly --preset canyon --frames 600 --out flight\n"
        "  isofront fly head.nrrd --isovalue 300 --out round\n"
        "  isofront fly dragon.voxels --out dragon");
    return [arguments] { return fly(*arguments); };
}

} // namespace isofront::cli
