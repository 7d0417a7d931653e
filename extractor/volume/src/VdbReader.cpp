#include "VdbReader.h"

#include "Assembly.h"
#include "Interpolation.h"
#include "MinMaxTree.h"
#include "ValueStatistics.h"

#include <isofront/core/Assert.h>

#include <openvdb/openvdb.h>

#include <array>
#include <optional>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using openvdb::Coord;
using openvdb::CoordBBox;

/// Reads a tree without registering with it, which would lock; safe because the tree never changes.
template <typename Tree>
using Reader = openvdb::tree::ValueAccessor<const Tree, false>;

constexpr int kBlockBits = 3; // a leaf of OpenVDB's standard trees has 8^3 voxels
constexpr int kBlockEdge = 1 << kBlockBits;

/// Smaller nodes than those of OpenVDB's standard trees, which would take more memory than the
/// bricks.
using BrickTree = openvdb::tree::Tree4<float, 3, 3, 3>::Type;

/// Bounds of a sparse volume. Like MinMaxTree, level 0 has the range of bricks of 8^3 interpolation
/// cells, 9^3 voxels, and every further level that of 2^3 bricks; but the bricks are stored as the
/// voxels of float trees, so that they are as sparse as the volume.
class SparseBounds {
public:
    /// @param sign  1, or -1 for bounds of the negated values
    template <typename Tree>
    SparseBounds(const Tree& tree, double sign, const CoordBBox& box) : _box(box)
    {
        buildFinest(tree, sign);
        // So far that the bricks of the last level along an axis are few enough for any query.
        const int extent = box.extents()[static_cast<std::size_t>(box.maxExtent())];
        while ((extent >> (kBlockBits + static_cast<int>(_levels.size()) - 1)) > kMostBricks - 2)
            _levels.push_back(
                {coarsened(*_levels.back().low, [](float a, float b) { return std::min(a, b); }),
                 coarsened(*_levels.back().high, [](float a, float b) { return std::max(a, b); })});
        const openvdb::Vec3d low = box.min().asVec3d();
        const openvdb::Vec3d high = box.max().asVec3d();
        _all = bounds({{low.x(), low.y(), low.z()}, {high.x(), high.y(), high.z()}});
    }

    /// What holds every sample at the points of the box, clamped to the data box.
    [[nodiscard]] core::Interval bounds(const core::Box& box) const
    {
        if (box.isEmpty())
            return _all;
        Coord first;
        Coord last;
        std::size_t level = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double lowest = _box.min()[axis];
            const double highest = _box.max()[axis];
            const double low = std::clamp(box.low[axis], lowest, highest);
            const double high = std::clamp(box.high[axis], lowest, highest);
            // A point on a voxel plane needs that plane only, and so belongs to either cell.
            const int firstCell = static_cast<int>(std::floor(low));
            const int lastCell = std::max(firstCell, static_cast<int>(std::ceil(high)) - 1);
            first[axis] = firstCell >> kBlockBits;
            last[axis] = lastCell >> kBlockBits;
            while ((last[axis] >> level) - (first[axis] >> level) >= kMostBricks)
                ++level;
        }
        const Level& bricks = _levels[level];
        const Reader<BrickTree> lows(*bricks.low);
        const Reader<BrickTree> highs(*bricks.high);
        float low = std::numeric_limits<float>::infinity();
        float high = -std::numeric_limits<float>::infinity();
        Coord brick;
        for (brick.x() = first.x() >> level; brick.x() <= last.x() >> level; ++brick.x()) {
            for (brick.y() = first.y() >> level; brick.y() <= last.y() >> level; ++brick.y()) {
                for (brick.z() = first.z() >> level; brick.z() <= last.z() >> level; ++brick.z()) {
                    low = std::min(low, lows.getValue(brick));
                    high = std::max(high, highs.getValue(brick));
                }
            }
        }
        return {static_cast<double>(low), static_cast<double>(high)};
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        std::uint64_t bytes = 0;
        for (const Level& level : _levels)
            bytes += level.low->memUsage() + level.high->memUsage();
        return bytes;
    }

private:
    /// A query looks at no more bricks than this along an axis; a larger box uses a coarser level.
    static constexpr int kMostBricks = 4;

    struct Level {
        BrickTree::Ptr low;
        BrickTree::Ptr high;
    };

    /// Extremes of the voxels of one block; along the axes in `shared` only of its first ones.
    template <typename Tree>
    static detail::Extremes<typename Tree::ValueType>
    blockExtremes(const Reader<Tree>& reader, double sign, Coord block, Coord shared)
    {
        using Value = typename Tree::ValueType;
        const Coord origin = block << kBlockBits;
        detail::Extremes<Value> found;
        const auto include = [&](Value value) { found.include(static_cast<Value>(sign) * value); };
        const auto* leaf = reader.probeConstLeaf(origin);
        if (leaf == nullptr) {
            include(reader.getValue(origin));
            return found;
        }
        const Value* values = leaf->buffer().data();
        const auto countAlong = [](int isShared) { return isShared != 0 ? 1 : kBlockEdge; };
        for (int x = 0; x < countAlong(shared.x()); ++x)
            for (int y = 0; y < countAlong(shared.y()); ++y)
                for (int z = 0; z < countAlong(shared.z()); ++z)
                    include(values[(x * kBlockEdge + y) * kBlockEdge + z]);
        return found;
    }

    template <typename Tree>
    void buildFinest(const Tree& tree, double sign)
    {
        using Value = typename Tree::ValueType;
        const Reader<Tree> reader(tree);
        const auto storeInto =
            [](Level& level, const CoordBBox& bricks, const core::Interval& range) {
                level.low->fill(bricks, static_cast<float>(range.low));
                level.high->fill(bricks, static_cast<float>(range.high));
            };
        detail::Extremes<Value> background;
        background.include(static_cast<Value>(sign) * tree.background());
        Level level{
            std::make_shared<BrickTree>(static_cast<float>(background.samples().low)),
            std::make_shared<BrickTree>(static_cast<float>(background.samples().high))};

        const auto setBrick = [&](Coord brick) {
            if (level.low->isValueOn(brick))
                return;
            detail::Extremes<Value> found;
            forCorners([&](Coord corner) {
                found.include(blockExtremes(reader, sign, brick + corner, corner));
            });
            level.low->setValueOn(brick, static_cast<float>(found.samples().low));
            level.high->setValueOn(brick, static_cast<float>(found.samples().high));
        };
        for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
            forCorners([&](Coord corner) { setBrick((leaf->origin() >> kBlockBits) - corner); });

        // Tiles, active or not: within them bricks are constant, those on their low sides and
        // across their high sides see the neighbours too.
        auto tile = tree.cbeginValueAll();
        tile.setMaxDepth(Tree::ValueAllCIter::LEAF_DEPTH - 1);
        for (; tile; ++tile) {
            if (*tile == tree.background())
                continue;
            CoordBBox voxels;
            tile.getBoundingBox(voxels);
            const CoordBBox inside(
                voxels.min() >> kBlockBits, (voxels.max() >> kBlockBits) - Coord(1));
            if (!inside.empty()) {
                detail::Extremes<Value> value;
                value.include(static_cast<Value>(sign) * *tile);
                storeInto(level, inside, value.samples());
            }
            const CoordBBox around(inside.min() - Coord(1), inside.max() + Coord(1));
            for (auto brick = around.begin(); brick; ++brick)
                if (!inside.isInside(*brick))
                    setBrick(*brick);
        }
        _levels.push_back(std::move(level));
    }

    /// One half of the next level. The halves are coarsened apart, because their tiles may differ.
    template <typename Combine>
    static BrickTree::Ptr coarsened(const BrickTree& fine, Combine combine)
    {
        auto coarse = std::make_shared<BrickTree>(fine.background());
        const Reader<BrickTree> reader(fine);
        for (auto value = fine.cbeginValueOn(); value; ++value) {
            CoordBBox bricks;
            value.getBoundingBox(bricks);
            if (!value.isVoxelValue()) { // a tile, at least 8^3: whole bricks of the next level
                coarse->fill({bricks.min() >> 1, bricks.max() >> 1}, *value);
                continue;
            }
            const Coord brick = bricks.min() >> 1;
            if (coarse->isValueOn(brick))
                continue;
            float found = reader.getValue(brick << 1);
            forCorners([&](Coord corner) {
                found = combine(found, reader.getValue((brick << 1) + corner));
            });
            coarse->setValueOn(brick, found);
        }
        return coarse;
    }

    template <typename Visit>
    static void forCorners(const Visit& visit)
    {
        for (int i = 0; i < 8; ++i)
            visit(Coord(i & 1, i >> 1 & 1, i >> 2 & 1));
    }

    CoordBBox _box;
    std::vector<Level> _levels; ///< finest first
    core::Interval _all;
};

/// A sparse volume as a field in index space; samples as in VolumeField, unfiltered at every
/// radius.
template <typename Grid>
class GridField final : public fields::Field {
public:
    GridField(typename Grid::ConstPtr grid, double sign, const CoordBBox& box)
        : _grid(std::move(grid)), _sign(sign), _box(box), _bounds(_grid->tree(), sign, box)
    {
    }

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "one value for each point");
        using detail::clampedTo;
        using detail::mixed;
        using Value = typename Grid::ValueType;
        const Reader<typename Grid::TreeType> reader(_grid->tree());
        const openvdb::Vec3d low = _box.min().asVec3d();
        const openvdb::Vec3d high = _box.max().asVec3d();
        std::array<double, 8> corner{}; // z fastest, as in a leaf
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const double x = clampedTo(low.x(), high.x(), batch.x[i]);
            const double y = clampedTo(low.y(), high.y(), batch.y[i]);
            const double z = clampedTo(low.z(), high.z(), batch.z[i]);
            const Coord cell(floored(x), floored(y), floored(z));
            gather(reader, cell, corner);
            const double tx = x - cell.x();
            const double ty = y - cell.y();
            const double tz = z - cell.z();
            const double near = mixed<Value>(
                mixed<Value>(corner[0], corner[4], tx), mixed<Value>(corner[2], corner[6], tx), ty);
            const double far = mixed<Value>(
                mixed<Value>(corner[1], corner[5], tx), mixed<Value>(corner[3], corner[7], tx), ty);
            values[i] = static_cast<float>(_sign * mixed<Value>(near, far, tz));
        }
    }

    [[nodiscard]] core::Interval
    bounds(const core::Box& box, core::Interval /*radius*/) const override
    {
        return _bounds.bounds(box);
    }

    [[nodiscard]] double differenceStep(double /*radius*/) const override { return 1.0; }

    [[nodiscard]] std::optional<core::Box> dataBox() const override
    {
        return core::Box{
            glm::dvec3(_box.min().x(), _box.min().y(), _box.min().z()),
            glm::dvec3(_box.max().x(), _box.max().y(), _box.max().z())};
    }

    [[nodiscard]] std::uint64_t memoryBytes() const
    {
        return _grid->memUsage() + _bounds.memoryBytes();
    }

private:
    static int floored(double coordinate)
    {
        const int truncated = static_cast<int>(coordinate);
        return truncated > coordinate ? truncated - 1 : truncated;
    }

    /// The eight voxels of a cell. Two cells in three lie within one leaf.
    static void
    gather(const Reader<typename Grid::TreeType>& reader, Coord cell, std::array<double, 8>& corner)
    {
        constexpr int kMask = kBlockEdge - 1;
        const int x = cell.x() & kMask;
        const int y = cell.y() & kMask;
        const int z = cell.z() & kMask;
        if (x < kMask && y < kMask && z < kMask) {
            const auto* leaf = reader.probeConstLeaf(cell);
            if (leaf == nullptr) {
                corner.fill(static_cast<double>(reader.getValue(cell)));
                return;
            }
            constexpr int kRow = kBlockEdge;
            constexpr int kSlice = kBlockEdge * kBlockEdge;
            const auto* first = leaf->buffer().data() + x * kSlice + y * kRow + z;
            corner = {
                static_cast<double>(first[0]),
                static_cast<double>(first[1]),
                static_cast<double>(first[kRow]),
                static_cast<double>(first[kRow + 1]),
                static_cast<double>(first[kSlice]),
                static_cast<double>(first[kSlice + 1]),
                static_cast<double>(first[kSlice + kRow]),
                static_cast<double>(first[kSlice + kRow + 1])};
            return;
        }
        for (std::size_t i = 0; i < 8; ++i)
            corner[i] = static_cast<double>(reader.getValue(cell.offsetBy(
                static_cast<int>(i >> 2U & 1U),
                static_cast<int>(i >> 1U & 1U),
                static_cast<int>(i & 1U))));
    }

    typename Grid::ConstPtr _grid;
    double _sign;
    CoordBBox _box;
    SparseBounds _bounds;
};

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
    auto field = std::make_shared<const GridField<Grid>>(grid, volume.negated ? -1.0 : 1.0, box);
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
