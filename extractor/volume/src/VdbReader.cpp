#include "VdbReader.h"

#include "Assembly.h"
#include "GridField.h"
#include "ValueStatistics.h"

#include <openvdb/openvdb.h>

#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using openvdb::CoordBBox;

/// OpenVDB multiplies row vectors from the left, so its rows are our columns.
core::Affine affineOf(const openvdb::math::Transform& transform)
{
    const openvdb::Mat4d matrix = transform.baseMap()->getAffineMap()->getMat4();
    core::Affine result;
    for (int row = 0; row < 3; ++row) {
        const auto axis = static_cast<std::size_t>(row);
        result.linear[axis] = {matrix(row, 0), matrix(row, 1), matrix(row, 2)};
        result.translation[axis] = matrix(3, row);
    }
    return result;
}

template <typename Grid>
core::Result<LoadedVolume>
volumeOf(const typename Grid::ConstPtr& grid, VoxelType type, const LoadOptions& options)
{
    if (!grid->transform().isLinear())
        return core::failure(
            ErrorCode::badData,
            "the grid has a perspective (frustum) transform; resample it to a "
            "uniform one");
    CoordBBox box = grid->evalActiveVoxelBoundingBox();
    if (grid->activeVoxelCount() == 0)
        return core::failure(ErrorCode::badData, "the grid has no active voxel");
    constexpr int kFarthest = 1 << 29; // so that sums and differences of coordinates fit an int
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (box.min()[axis] < -kFarthest || box.max()[axis] > kFarthest)
            return core::failure(
                ErrorCode::badData,
                "the grid has active voxels beyond index 2^29; move or resample it");
    box.expand(1);

    LoadedVolume volume;
    const core::Box dataBox{
        glm::dvec3(box.min().x(), box.min().y(), box.min().z()),
        glm::dvec3(box.max().x(), box.max().y(), box.max().z())};
    if (const auto placed = placeVolume(volume, affineOf(grid->transform()), dataBox); !placed)
        return tl::unexpected(placed.error());
    VolumeInfo& info = volume.info;
    info.format = VolumeFormat::vdb;
    info.voxelType = type;
    info.values = summarised([&](auto&& visit) {
        for (auto value = grid->cbeginValueOn(); value; ++value)
            visit(static_cast<double>(*value), value.getVoxelCount());
    });
    if (const auto finite = checkFinite(info.values); !finite)
        return tl::unexpected(finite.error());
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());

    volume.negated = grid->getGridClass() == openvdb::GRID_LEVEL_SET;
    if (volume.negated) {
        info.suggestedIsovalue = 0;
        info.orientation = "The level set is negated with its isovalue, because its values are "
                           "negative inside: solid is where the file's values are at or below the "
                           "isovalue.";
    } else {
        info.suggestedIsovalue = otsuThreshold(info.values);
        info.orientation = "The values are as in the file: solid is where they are at or above the "
                           "isovalue.";
    }
    auto field =
        std::make_shared<const detail::GridField<Grid>>(grid, volume.negated ? -1.0 : 1.0, box);
    info.memoryBytes = field->memoryBytes();
    volume.field = std::move(field);
    return volume;
}

bool isScalar(const VdbGridEntry& grid)
{
    return grid.type == openvdb::FloatGrid::gridType() ||
           grid.type == openvdb::DoubleGrid::gridType();
}

std::string listed(const std::vector<VdbGridEntry>& grids)
{
    std::string names;
    for (const VdbGridEntry& grid : grids)
        names += (names.empty() ? "\"" : ", \"") + grid.name + "\" (" + grid.type + ")";
    return names.empty() ? "none" : names;
}

/// The grid asked for, or the first that we can read.
core::Result<VdbGridEntry> chosen(const std::vector<VdbGridEntry>& grids, const std::string& name)
{
    const auto found = std::find_if(grids.begin(), grids.end(), [&](const VdbGridEntry& grid) {
        return name.empty() ? isScalar(grid) : grid.name == name;
    });
    if (found == grids.end() && name.empty())
        return core::failure(
            ErrorCode::badData,
            "the file has no grid of floats or doubles; its grids are: " + listed(grids));
    if (found == grids.end())
        return core::failure(
            ErrorCode::usage,
            "the file has no grid named \"" + name + "\"; its grids are: " + listed(grids));
    if (!isScalar(*found))
        return core::failure(
            ErrorCode::badData,
            "the grid \"" + name + "\" has type " + found->type +
                "; only grids of floats or doubles can be read");
    return *found;
}

} // namespace

core::Result<LoadedVolume> readThroughOpenVdb(
    const std::filesystem::path& path,
    const std::vector<VdbGridEntry>& grids,
    const LoadOptions& options)
{
    const auto entry = chosen(grids, options.gridName);
    if (!entry)
        return tl::unexpected(entry.error());

    openvdb::initialize();
    openvdb::io::File file(path.string());
    constexpr bool kDelayed = false; // values read on demand would lock while sampling
    file.open(kDelayed);
    const auto metadata = file.readGridMetadata(entry->name);
    const auto promised =
        metadata->getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_MEM_BYTES);
    const auto tooLarge = [&](std::uint64_t bytes) {
        return core::failure(
            ErrorCode::resourceLimit,
            "the grid \"" + entry->name + "\" takes " + std::to_string(bytes >> 20U) +
                " MiB, which is above the limit of " + std::to_string(options.memoryLimit >> 20U) +
                " MiB; raise the limit or resample the grid");
    };
    if (promised && promised->value() > 0 &&
        static_cast<std::uint64_t>(promised->value()) > options.memoryLimit)
        return tooLarge(static_cast<std::uint64_t>(promised->value()));
    const openvdb::GridBase::ConstPtr grid = file.readGrid(entry->name);
    file.close();
    if (grid->memUsage() > options.memoryLimit)
        return tooLarge(grid->memUsage());
    if (const auto stopped = checkStop(options); !stopped)
        return tl::unexpected(stopped.error());

    auto volume =
        grid->isType<openvdb::FloatGrid>()
            ? volumeOf<openvdb::FloatGrid>(
                  openvdb::gridConstPtrCast<openvdb::FloatGrid>(grid), VoxelType::float32, options)
            : volumeOf<openvdb::DoubleGrid>(
                  openvdb::gridConstPtrCast<openvdb::DoubleGrid>(grid),
                  VoxelType::float64,
                  options);
    if (!volume)
        return tl::unexpected(volume.error().within("grid \"" + entry->name + "\""));
    volume->info.gridName = entry->name;
    for (const VdbGridEntry& each : grids)
        volume->info.gridNames.push_back(each.name);
    if (options.gridName.empty() && grids.size() > 1)
        volume->info.notes.push_back(
            "The file has several grids; \"" + entry->name +
            "\" was taken, the first with scalar values. Its grids are: " + listed(grids) + ".");
    return volume;
}

} // namespace isofront::volume
