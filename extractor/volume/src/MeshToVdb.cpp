#include "Assembly.h"
#include "GridField.h"
#include "MeshLevelSet.h"
#include "ShellField.h"
#include "ValueStatistics.h"

#include <openvdb/math/Proximity.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/MeshToVolume.h>
#include <openvdb/tools/ValueTransformer.h>
#include <openvdb/tree/LeafManager.h>
#include <openvdb/util/Util.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using openvdb::FloatGrid;

/// Half the thickness of a shell [voxels]. What is interpolated between the distances of a cell's
/// voxels is at most sqrt(3)/2 where the mesh is: so there are no holes from 1 on. Around open
/// edges a tube of that radius would be too thin for the voxels, and have handles.
constexpr float kShell = 1.5F;

/// A mesh as OpenVDB asks for it.
struct Polygons {
    const IndexedMesh& mesh;

    [[nodiscard]] std::size_t polygonCount() const { return mesh.corners.size(); }
    [[nodiscard]] std::size_t pointCount() const { return mesh.positions.size(); }
    [[nodiscard]] std::size_t vertexCount(std::size_t /*polygon*/) const { return 3; }
    void getIndexSpacePoint(std::size_t polygon, std::size_t corner, openvdb::Vec3d& point) const
    {
        const glm::dvec3& p = mesh.positions[mesh.corners[polygon][corner]];
        point = {p.x, p.y, p.z};
    }
};

struct Interrupter final : openvdb::util::NullInterrupter {
    explicit Interrupter(std::stop_token token) : stop(std::move(token)) {}
    bool wasInterrupted(int /*percent*/ = -1) override { return stop.stop_requested(); }

    std::stop_token stop;
};

/// Replaces distances by those from triangles that neighbouring voxels know, where these are
/// nearer. OpenVDB leaves voxels a few steps from the mesh with the first triangles that came
/// across them.
class Improvement {
public:
    Improvement(const Polygons& polygons, FloatGrid& distances, openvdb::Int32Grid& nearest)
        : _polygons(polygons), _distances(distances.tree()), _nearest(nearest.tree())
    {
    }

    /// @return false after a stop was requested
    bool run(const std::stop_token& stop)
    {
        // What is missed is known two voxels away at most; the third pass is for what it reveals.
        constexpr int kPasses = 3;
        openvdb::tree::LeafManager<IndexTree> leaves(_nearest, 1);
        leaves.foreach ([](IndexTree::LeafNodeType& leaf, std::size_t number) {
            leaf.setTransientData(static_cast<openvdb::Index32>(number));
        });
        _news.assign(leaves.leafCount(), News{true}); // at first all is news
        std::vector<News> next(leaves.leafCount());
        for (int pass = 0; pass < kPasses; ++pass) {
            leaves.foreach ([&](IndexTree::LeafNodeType& leaf, std::size_t number) {
                auto& improved = leaves.getBuffer(number, 1);
                improved = leaf.buffer();
                next[number] = stop.stop_requested() ? News{false} : improve(leaf, improved);
            });
            if (stop.stop_requested())
                return false;
            leaves.swapLeafBuffer(1);
            _news.swap(next);
        }
        return true;
    }

private:
    using IndexTree = openvdb::Int32Tree;
    using Leaf = IndexTree::LeafNodeType;
    /// Voxels of a leaf that know another triangle than a pass before. Only of these can their
    /// neighbours learn anything.
    using News = openvdb::util::NodeMask<Leaf::LOG2DIM>;

    /// The indices of a leaf's voxels and of those around; unknown where there is no news.
    struct Neighbourhood {
        static constexpr int kEdge = static_cast<int>(Leaf::DIM) + 2;

        std::array<openvdb::Int32, static_cast<std::size_t>(kEdge* kEdge* kEdge)> indices{};
        bool hasNews = false;

        /// @param place  relative to the leaf's first voxel, from -1 on
        static std::size_t at(const openvdb::Coord& place)
        {
            return static_cast<std::size_t>(
                ((place.x() + 1) * kEdge + place.y() + 1) * kEdge + place.z() + 1);
        }
    };

    static openvdb::Int32 unknown()
    {
        return static_cast<openvdb::Int32>(openvdb::util::INVALID_IDX);
    }

    Neighbourhood neighbourhoodOf(const Leaf& leaf) const
    {
        constexpr int kDim = static_cast<int>(Leaf::DIM);
        Neighbourhood around;
        around.indices.fill(unknown());
        const openvdb::tree::ValueAccessor<const IndexTree, false> nearest(_nearest);
        openvdb::Coord step;
        for (step.x() = -1; step.x() <= 1; ++step.x())
            for (step.y() = -1; step.y() <= 1; ++step.y())
                for (step.z() = -1; step.z() <= 1; ++step.z()) {
                    const openvdb::Coord offset(step.x() * kDim, step.y() * kDim, step.z() * kDim);
                    const Leaf* const other = nearest.probeConstLeaf(leaf.origin() + offset);
                    if (other == nullptr)
                        continue;
                    const News& news = _news[other->transientData()];
                    if (news.isOff())
                        continue;
                    const openvdb::Coord first =
                        openvdb::Coord::maxComponent(openvdb::Coord(-1), offset);
                    const openvdb::Coord last = openvdb::Coord::minComponent(
                        openvdb::Coord(kDim), offset.offsetBy(kDim - 1));
                    openvdb::Coord place;
                    for (place.x() = first.x(); place.x() <= last.x(); ++place.x())
                        for (place.y() = first.y(); place.y() <= last.y(); ++place.y())
                            for (place.z() = first.z(); place.z() <= last.z(); ++place.z()) {
                                const openvdb::Index voxel = Leaf::coordToOffset(place);
                                if (news.isOff(voxel))
                                    continue;
                                around.indices[Neighbourhood::at(place)] = other->getValue(voxel);
                                around.hasNews = true;
                            }
                }
        return around;
    }

    /// Reads the voxels around those of a leaf, and changes nothing but the leaf's own distances.
    News improve(const Leaf& leaf, Leaf::Buffer& improved)
    {
        News news{false};
        auto* const own = _distances.probeLeaf(leaf.origin());
        if (own == nullptr)
            return news;
        const Neighbourhood around = neighbourhoodOf(leaf);
        if (!around.hasNews)
            return news;
        std::array<openvdb::Int32, 27> seen{}; // neighbours mostly know the same few
        for (auto value = own->beginValueOn(); value; ++value) {
            const openvdb::Coord voxel = value.getCoord();
            const openvdb::Coord place = voxel - leaf.origin();
            openvdb::Int32 index = leaf.getValue(value.pos());
            const float before = std::abs(*value);
            float least = before;
            seen[0] = index;
            std::size_t count = 1;
            for (int i = 0; i < 26; ++i) {
                const openvdb::Int32 other =
                    around.indices[Neighbourhood::at(place + openvdb::util::COORD_OFFSETS[i])];
                const auto end = seen.begin() + static_cast<std::ptrdiff_t>(count);
                if (other == unknown() || std::find(seen.begin(), end, other) != end)
                    continue;
                seen[count++] = other;
                const float distance = distanceTo(static_cast<std::size_t>(other), voxel);
                if (distance < least) {
                    least = distance;
                    index = other;
                }
            }
            if (!(least < before))
                continue;
            improved.setValue(value.pos(), index);
            value.setValue(std::copysign(least, *value));
            news.setOn(value.pos());
        }
        return news;
    }

    [[nodiscard]] float distanceTo(std::size_t polygon, const openvdb::Coord& voxel) const
    {
        openvdb::Vec3d a;
        openvdb::Vec3d b;
        openvdb::Vec3d c;
        openvdb::Vec3d weights;
        _polygons.getIndexSpacePoint(polygon, 0, a);
        _polygons.getIndexSpacePoint(polygon, 1, b);
        _polygons.getIndexSpacePoint(polygon, 2, c);
        const openvdb::Vec3d point = voxel.asVec3d();
        return static_cast<float>(
            (point - openvdb::math::closestPointOnTriangleToPoint(a, c, b, point, weights))
                .length());
    }

    const Polygons& _polygons;
    FloatGrid::TreeType& _distances;
    IndexTree& _nearest;
    std::vector<News> _news; ///< by the leaf's number
};

/// Distances in voxels.
/// @return null after a stop was requested
FloatGrid::Ptr
distances(const IndexedMesh& mesh, float reach, bool isSigned, const std::stop_token& stop)
{
    // OpenVDB evens bumps out where parts of a mesh overlap, and thereby moves distances elsewhere.
    const int flags = openvdb::tools::DISABLE_RENORMALIZATION |
                      (isSigned ? 0 : static_cast<int>(openvdb::tools::UNSIGNED_DISTANCE_FIELD));
    Interrupter interrupter(stop);
    const Polygons polygons{mesh};
    // In voxels, because OpenVDB takes maps of voxels below a hundredth of a millimetre for flat.
    const auto identity = openvdb::math::Transform::createLinearTransform(1.0);
    openvdb::Int32Grid nearest(static_cast<openvdb::Int32>(openvdb::util::INVALID_IDX));
    auto grid = openvdb::tools::meshToVolume<FloatGrid>(
        interrupter, polygons, *identity, reach, reach, flags, &nearest);
    if (stop.stop_requested() || !Improvement(polygons, *grid, nearest).run(stop))
        return nullptr;
    return grid;
}

bool hasInside(const FloatGrid& grid)
{
    for (auto value = grid.cbeginValueAll(); value; ++value)
        if (*value < 0)
            return true;
    return false;
}

/// v becomes (v - offset) * scale.
void transformValues(FloatGrid& grid, float offset, float scale)
{
    const auto changed = [=](float value) { return (value - offset) * scale; };
    FloatGrid::TreeType& tree = grid.tree();
    tree.root().setBackground(changed(tree.background()), false);
    auto change = [changed](const FloatGrid::TreeType::ValueAllIter& value) {
        value.setValue(changed(*value));
    };
    openvdb::tools::foreach (tree.beginValueAll(), change);
}

std::string brief(double value)
{
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", value);
    return text;
}

} // namespace

core::Result<LoadedVolume>
levelSetThroughOpenVdb(const IndexedMesh& mesh, double reach, const LevelSetOptions& options)
{
    const auto stopped = [] {
        return core::failure(ErrorCode::interrupted, "loading was stopped");
    };
    openvdb::initialize();
    // One more voxel, so that what is interpolated up to the reach is known.
    const float band = static_cast<float>(reach) + 1;
    LoadedVolume volume;
    VolumeInfo& info = volume.info;
    FloatGrid::Ptr grid;
    bool isSolid = options.isSolid;
    if (isSolid) {
        grid = distances(mesh, band, true, options.stop);
        if (!grid)
            return stopped();
        if (!hasInside(*grid)) {
            isSolid = false;
            info.notes.push_back(
                "The mesh encloses nothing that a voxel of " + brief(mesh.voxel) +
                " could hold: a shell around its triangles is solid.");
        }
    }
    if (!isSolid) {
        grid = distances(mesh, band + kShell, false, options.stop);
        if (!grid)
            return stopped();
    }
    transformValues(*grid, isSolid ? 0 : kShell, static_cast<float>(mesh.voxel));
    openvdb::CoordBBox box = grid->evalActiveVoxelBoundingBox();
    box.expand(1);

    const core::Box dataBox{
        glm::dvec3(box.min().x(), box.min().y(), box.min().z()),
        glm::dvec3(box.max().x(), box.max().y(), box.max().z())};
    core::Affine worldFromIndex;
    worldFromIndex.linear = glm::dmat3(mesh.voxel);
    worldFromIndex.translation = mesh.origin;
    if (const auto placed = placeVolume(volume, worldFromIndex, dataBox); !placed)
        return tl::unexpected(placed.error());
    info.format = VolumeFormat::mesh;
    info.voxelType = VoxelType::float32;
    info.values = summarised([&](auto&& visit) {
        for (auto value = grid->cbeginValueOn(); value; ++value)
            visit(static_cast<double>(*value), value.getVoxelCount());
    });
    if (const auto finite = checkFinite(info.values); !finite)
        return tl::unexpected(finite.error());
    info.suggestedIsovalue = 0;
    info.orientation =
        isSolid ? "The distance from the mesh is negated with its isovalue, because it is negative "
                  "inside: solid is where the distance is at or below the isovalue."
                : "The distance from a shell around the mesh's triangles is negated with its "
                  "isovalue: solid is where the distance is at or below the isovalue.";
    volume.negated = true;
    auto field = std::make_shared<const detail::GridField<FloatGrid>>(grid, -1.0, box);
    info.memoryBytes = field->memoryBytes();
    volume.field = std::move(field);
    if (!isSolid) // and outside stays outside
        volume.field =
            std::make_shared<const detail::ShellField>(volume.field, mesh.voxel, 0.5 * reach);
    if (options.stop.stop_requested())
        return stopped();
    return volume;
}

} // namespace isofront::volume
