#include "FarField.h"

#include "Arguments.h"
#include "FieldVoxels.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <system_error>
#include <utility>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Store = std::shared_ptr<const voxels::ChunkStore>;

/// More are better made once and kept in a file.
constexpr std::uint32_t kMostInMemory = 8192;
const std::string kOption = "--far-voxels ";

/// With all its digits.
std::string exact(double number)
{
    return nlohmann::json(number).dump();
}

/// But for the last digits, which come of how a number was computed.
bool isSame(double a, double b)
{
    return std::abs(a - b) <= 1e-6 * std::max(std::abs(a), std::abs(b));
}

/// Whether names of sources tell the same file with another `--detail`.
bool isOtherDetail(const std::string& a, const std::string& b)
{
    constexpr const char* kDetail = "?detail=";
    const std::size_t at = a.find(kDetail);
    return at != std::string::npos && at == b.find(kDetail) && a.substr(0, at) == b.substr(0, at);
}

/// Takes away what the meshes don't have.
class WithoutColours final : public voxels::ChunkSink {
public:
    explicit WithoutColours(voxels::ChunkSink& sink) : _sink(sink) {}

    std::optional<core::Error> put(voxels::Chunk chunk) override
    {
        chunk.colours.clear();
        for (voxels::FaceAttributes& face : chunk.faceAttributes)
            face.colour = 0;
        return _sink.put(std::move(chunk));
    }

private:
    voxels::ChunkSink& _sink;
};

/// Whether a model is of the surface that is to be shown. If not, the error says what both are.
core::Result<void>
checkField(const voxels::StoredModel& model, const Source& source, const FarFieldSurface& surface)
{
    const auto fail = [&](const std::string& what, const std::string& instead) {
        return core::failure(
            ErrorCode::usage, "its voxels are " + what + ", and what is shown is " + instead);
    };
    if (!model.field)
        return fail(
            "of " + model.name +
                (model.source ? ", a mesh" : ", without a word of isovalue and filter"),
            source.identity + "; voxelise that");
    const voxels::ModelField& field = *model.field;
    if (field.source != source.identity)
        return fail(
            "of " + field.source,
            "of " + source.identity +
                (isOtherDetail(field.source, source.identity) ? "; give both the same --detail"
                                                              : "; voxelise that"));
    if (field.isovalue != surface.isovalue)
        return fail(
            "of isovalue " + exact(field.isovalue),
            "of isovalue " + exact(surface.isovalue) + "; give both the same --isovalue");
    if (!isSame(field.filter, surface.filter) && !isSame(field.filter, surface.voxelFilter))
        return fail(
            "filtered by " + exact(field.filter),
            "filtered by " + exact(surface.filter) +
                "; give both the same --filter, or voxelise with --filter " +
                brief(surface.voxelFilter) + ", which looks like it");
    if (field.closed != surface.closed)
        return fail(
            field.closed ? "closed at the border" : "open at the border",
            std::string(surface.closed ? "closed" : "open") + "; give both --closed, or neither");
    if (field.checksum != checksumOf(source))
        return fail(
            "of another " + source.identity,
            "of the one that is there now, or read with other options; voxelise it again");
    return {};
}

core::Result<Store>
openModel(const std::filesystem::path& path, const Source& source, const FarFieldSurface& surface)
{
    auto opened = voxels::openAnyStore(path);
    if (!opened)
        return tl::unexpected(opened.error().within("--far-voxels"));
    if (const auto checked = checkField((*opened)->model(), source, surface); !checked)
        return tl::unexpected(checked.error().within(kOption + path.string()));
    return Store(std::move(*opened));
}

core::Result<Store> voxelised(
    std::uint32_t resolution,
    const Source& source,
    const FarFieldSurface& surface,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop)
{
    const auto settings = fieldVoxelSettings(
        source,
        {.resolution = resolution,
         .isovalue = surface.isovalue,
         .filter = surface.voxelFilter,
         .closed = surface.closed});
    if (!settings)
        return tl::unexpected(settings.error());
    std::unique_ptr<voxels::ChunkStore> store = voxels::memoryStore();
    WithoutColours sink(*store);
    std::atomic<bool> cancelled = false;
    const std::stop_callback cancelling(stop, [&] { cancelled = true; });
    const auto made =
        voxels::voxelizeField(*source.field, *settings, sink, jobs, &cancelled, [&](double share) {
            progress.show("far voxels", share);
        });
    if (!made)
        return tl::unexpected(made.error());
    voxels::StoredModel model;
    model.name = source.name;
    model.lattice = made->lattice;
    model.voxels = made->voxels;
    model.allVoxels = made->allVoxels;
    model.chunks = made->chunks;
    if (const auto failed = store->finish(model))
        return tl::unexpected(*failed);
    return Store(std::move(store));
}

core::Error notUnderstood(const std::string& text)
{
    return {
        ErrorCode::usage,
        kOption + ("'" + text) + "': give a whole number of voxels along the longest edge, 2 to " +
            std::to_string(kMostInMemory) +
            ", as in 1024, or the path of a model that 'isofront voxelize' has made"};
}

bool isNumberLike(const std::string& text)
{
    return std::ranges::all_of(
        text, [](char c) { return (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '+'; });
}

} // namespace

void FarFieldOptions::addTo(CLI::App& command)
{
    CLI::Option* farVoxels =
        command
            .add_option(
                "--far-voxels",
                voxels,
                "show the distance as surface voxels: so many along the longest edge, made first, "
                "or a model that 'isofront voxelize' made of the same source")
            ->type_name("N|MODEL");
    command
        .add_option(
            "--hand-over",
            handOver,
            "error of voxels below which they take the place of meshes [px]")
        ->check(within(0.05, 100.0))
        ->needs(farVoxels)
        ->capture_default_str();
}

core::Result<std::optional<FarFieldRequest>> farFieldRequest(const FarFieldOptions& options)
{
    if (!options.voxels)
        return std::nullopt;
    const std::string& text = *options.voxels;
    std::error_code ignored;
    if (!text.empty() && !isNumberLike(text)) {
        const std::filesystem::path path = text;
        if (std::filesystem::exists(path, ignored))
            return FarFieldRequest{.model = path};
        if (!path.has_parent_path() && !path.has_extension())
            return tl::unexpected(notUnderstood(text));
        return core::failure(
            ErrorCode::inputOutput, kOption + text + ": there is no such file; check the path");
    }
    FarFieldRequest request;
    const char* const last = text.data() + text.size();
    const auto [end, failed] = std::from_chars(text.data(), last, request.resolution);
    if (text.empty() || end != last || failed == std::errc::invalid_argument)
        return tl::unexpected(notUnderstood(text));
    if (failed != std::errc() || request.resolution < 2 || request.resolution > kMostInMemory)
        return core::failure(
            ErrorCode::usage,
            kOption + text + ": it must be 2 to " + std::to_string(kMostInMemory) +
                "; for more, make a model with 'isofront voxelize' and name that");
    return request;
}

core::Result<Store> openFarField(
    const FarFieldRequest& request,
    const Source& source,
    const FarFieldSurface& surface,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop)
{
    auto opened = request.resolution > 0
                      ? voxelised(request.resolution, source, surface, jobs, progress, stop)
                      : openModel(request.model, source, surface);
    if (!opened)
        return opened;
    const voxels::StoredModel& model = (*opened)->model();
    progress.say(
        "far field: " + grouped(model.voxels) + " voxels, " + grouped(model.allVoxels) + " in " +
        std::to_string(model.lattice.levels) + " levels of detail");
    return opened;
}

std::string coarseFarFieldNote(
    const render::HandOver& handOver,
    std::uint32_t resolution,
    const core::Box& scene,
    std::span<const hierarchy::View> views)
{
    constexpr double kWithin = 0.7; // of the way to the farthest corner voxels should take over
    double times = std::numeric_limits<double>::infinity(); // as many voxels are needed
    double nearest = times;
    for (const hierarchy::View& view : views) {
        const double takesOver = handOver.distance(view);
        const glm::dvec3 far =
            glm::max(glm::abs(scene.low - view.eye), glm::abs(scene.high - view.eye));
        nearest = std::min(nearest, takesOver);
        times = std::min(times, takesOver / glm::length(far));
    }
    if (!(times > 1))
        return {};
    const auto enough = static_cast<std::uint64_t>(std::ceil(times / kWithin * resolution));
    std::string note = "note: nothing is far enough for so coarse voxels, which take over from " +
                       brief(nearest) + " on: ";
    if (enough <= kMostInMemory)
        note += "--far-voxels " + std::to_string(enough) + " would, or ";
    else if (enough <= voxels::kMaxResolution)
        note +=
            "a model of 'isofront voxelize --resolution " + std::to_string(enough) + "' would, or ";
    return note + "a larger --hand-over";
}

} // namespace isofront::cli
