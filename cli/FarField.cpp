#include "FarField.h"

#include "FieldVoxels.h"

#include <glm/common.hpp>

#include <algorithm>
#include <atomic>
#include <charconv>
#include <filesystem>
#include <utility>

namespace isofront::cli {

namespace {

using core::ErrorCode;
using Store = std::shared_ptr<const voxels::ChunkStore>;

/// More are better made once and kept in a file.
constexpr std::uint32_t kMostInMemory = 8192;
constexpr const char* kOption = "--far-voxels ";

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

core::Result<Store> openModel(const std::string& path, const Source& source, Progress& progress)
{
    auto opened = voxels::openAnyStore(path);
    if (!opened)
        return tl::unexpected(opened.error().within("--far-voxels"));
    const Store store = std::move(*opened);
    const auto box = voxels::worldBox(*store);
    if (!box)
        return tl::unexpected(box.error());
    const bool isElsewhere =
        !box->isEmpty() && (glm::any(glm::lessThan(box->high, source.worldBox.low)) ||
                            glm::any(glm::greaterThan(box->low, source.worldBox.high)));
    if (isElsewhere)
        return core::failure(
            ErrorCode::usage,
            kOption + path + ": its voxels lie where " + source.name +
                " has nothing; voxelise that source");
    const std::string name =
        source.isProcedural ? source.name : std::filesystem::path(source.name).filename().string();
    if (store->model().name != name)
        progress.say("note: " + path + " was made of " + store->model().name + ", not of " + name);
    return store;
}

core::Result<Store> voxelised(
    std::uint32_t resolution,
    const Source& source,
    double isovalue,
    double filter,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop)
{
    const auto settings = fieldVoxelSettings(
        source, {.resolution = resolution, .isovalue = isovalue, .filter = filter});
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
    progress.say(
        "far field: " + grouped(made->voxels) + " voxels, " + grouped(made->allVoxels) + " in " +
        std::to_string(made->lattice.levels) + " levels of detail");
    return Store(std::move(store));
}

} // namespace

core::Result<Store> openFarField(
    const std::string& text,
    const Source& source,
    double isovalue,
    double filter,
    core::Jobs& jobs,
    Progress& progress,
    const std::stop_token& stop)
{
    std::uint32_t resolution = 0;
    const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), resolution);
    const bool isNumber =
        !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
    if (!isNumber)
        return openModel(text, source, progress);
    if (failed != std::errc() || resolution < 2 || resolution > kMostInMemory)
        return core::failure(
            ErrorCode::usage,
            kOption + text + ": it must be 2 to " + std::to_string(kMostInMemory) +
                "; for more, make a model with 'isofront voxelize' and name that");
    return voxelised(resolution, source, isovalue, filter, jobs, progress, stop);
}

} // namespace isofront::cli
