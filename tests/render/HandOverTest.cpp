#include "support/Random.h"
#include "voxels/Models.h"

#include <isofront/hierarchy/Front.h>
#include <isofront/render/HandOver.h>
#include <isofront/surface/SurfaceCriterion.h>
#include <isofront/voxels/Voxelization.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace isofront::render {
namespace {

constexpr int kLattice = 8;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// A hilly sphere in a domain of edge 4, as voxels.
class HandOverTest : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        _chunks = std::make_unique<tests::KeptChunks>();
        const auto jobs = core::makeJobs(core::JobsBackend::automatic);
        const voxels::TriangleModel model =
            tests::hillySphere(40, 1.0, 0.2, glm::dvec3(2.0, 2.0, 2.0));
        const auto report = voxels::voxelize(model, {.resolution = 520}, *_chunks, *jobs);
        ASSERT_TRUE(report) << report.error().message;
        std::vector<voxels::ChunkEntry> directory;
        for (const auto& [key, chunk] : _chunks->chunks)
            directory.push_back(voxels::entryOf(chunk));
        auto tree = voxels::ChunkTree::create(report->lattice, directory);
        ASSERT_TRUE(tree) << tree.error().message;
        _tree = std::make_unique<voxels::ChunkTree>(std::move(*tree));
    }
    static void TearDownTestSuite()
    {
        _tree.reset();
        _chunks.reset();
    }

    static const voxels::ChunkTree& tree() { return *_tree; }
    static const std::map<voxels::ChunkKey, voxels::Chunk>& chunks() { return _chunks->chunks; }
    static const hierarchy::Domain& domain()
    {
        static const hierarchy::Domain domain{.origin = glm::dvec3(0.0), .edge = 4.0};
        return domain;
    }
    static HandOver handOver(const HandOverSettings& settings = {})
    {
        auto made = HandOver::create(
            tree(), &chunks().at(tree()[0].entry.key), domain(), kLattice, settings);
        EXPECT_TRUE(made) << made.error().message;
        return std::move(*made);
    }
    static hierarchy::View viewFrom(const glm::dvec3& eye)
    {
        hierarchy::View view;
        view.eye = eye;
        view.forward = {0.3, 1.0, 0.1};
        view.height = 180; // so that voxels of this size matter at distances of this size
        view.width = 320;
        return view;
    }
    template <typename Visit>
    static void forEachBlock(const BlockGrid& grid, const Visit& visit)
    {
        for (std::uint32_t z = 0; z < grid.count.z; ++z)
            for (std::uint32_t y = 0; y < grid.count.y; ++y)
                for (std::uint32_t x = 0; x < grid.count.x; ++x)
                    visit(glm::uvec3(x, y, z));
    }
    static std::vector<bool> occupiedBlocks(const BlockGrid& grid)
    {
        std::vector<bool> occupied(grid.size(), false);
        for (const auto& [key, chunk] : chunks()) {
            if (key.level > 0)
                continue;
            for (const voxels::Voxel& voxel : chunk.voxels)
                occupied[grid.index(
                    {(key.x * 256 + voxel.x()) >> grid.bits,
                     (key.y * 256 + voxel.y()) >> grid.bits,
                     (key.z * 256 + voxel.z()) >> grid.bits})] = true;
        }
        return occupied;
    }
    /// A cell whose mesh is a triangle that spans its box.
    static surface::ShownCell cellOf(const surface::CellId& id, float errorRms = 0)
    {
        const hierarchy::Tetrahedron cell = hierarchy::tetrahedronOf(id);
        auto mesh = std::make_shared<extractor::CellMesh>();
        mesh->low = cell.low();
        const std::uint32_t size = cell.high().x - cell.low().x;
        mesh->exponent = 1;
        while ((std::uint64_t{size} << hierarchy::kGridBitsPerLatticeUnit >> mesh->exponent) >
               32768)
            ++mesh->exponent;
        const auto most = static_cast<std::uint16_t>(
            std::uint64_t{size} << hierarchy::kGridBitsPerLatticeUnit >> mesh->exponent);
        const auto none = std::uint16_t{0};
        for (const std::array<std::uint16_t, 3>& at :
             {std::array{none, none, none},
              std::array{most, most, none},
              std::array{most, none, most}})
            mesh->vertices.push_back({.position = at});
        mesh->indices = {0, 1, 2};
        mesh->stats.errorRms = errorRms;
        return {id, mesh};
    }
    /// All cells of a front, as meshes.
    static surface::Delta deltaOf(const hierarchy::Front& front, float errorRms = 0)
    {
        surface::Delta delta;
        front.forEachCell([&](const surface::CellId& id, const hierarchy::Tetrahedron&) {
            delta.added.push_back(cellOf(id, errorRms));
        });
        return delta;
    }
    static hierarchy::Front uniformFront(int level)
    {
        hierarchy::Front front;
        for (int i = 0; i < level; ++i)
            for (const hierarchy::FrontDiamond& diamond : front.diamondsWithCells())
                if (!front.isSplit(diamond.centre))
                    front.refine(diamond.centre);
        return front;
    }
    static double distanceTo(const core::Box& box, const glm::dvec3& eye)
    {
        return glm::distance(glm::clamp(eye, box.low, box.high), eye);
    }

    static inline std::unique_ptr<tests::KeptChunks> _chunks;
    static inline std::unique_ptr<voxels::ChunkTree> _tree;
};

TEST_F(HandOverTest, cutsTheModelIntoBlocksThatHoldAllOfIt)
{
    const HandOver subject = handOver();
    const BlockGrid& grid = subject.grid();
    EXPECT_EQ(grid.edge, std::ldexp(tree().lattice().edge, int(grid.bits)));
    EXPECT_EQ(grid.bits, 5U);
    std::size_t count = 0;
    forEachBlock(grid, [&](const glm::uvec3& block) {
        EXPECT_EQ(grid.index(block), count++);
        EXPECT_EQ(grid.blockAt(grid.boxOf(block).centre()), block);
    });
    EXPECT_EQ(count, grid.size());
    const std::vector<bool> occupied = occupiedBlocks(grid);
    const auto expected = static_cast<std::size_t>(std::ranges::count(occupied, true));
    EXPECT_GT(expected, 100U);
    EXPECT_LT(expected, grid.size());
    EXPECT_EQ(subject.meshBlocks(), expected) << "meshes have everything at first";
    EXPECT_EQ(subject.voxelBlocks(), 0U);
    EXPECT_EQ(grid.blockAt(glm::dvec3(-1e30)), glm::uvec3(0U));
    EXPECT_EQ(grid.blockAt(glm::dvec3(1e30)), grid.count - 1U);
}

TEST_F(HandOverTest, givesVoxelsWhatIsFarAndMeshesWhatIsNear)
{
    HandOver subject = handOver();
    subject.apply(deltaOf(uniformFront(6), 1e-6F));
    const hierarchy::View view = viewFrom({2.0, 0.7, 2.3});
    EXPECT_TRUE(subject.begin(view, {}));
    EXPECT_GT(subject.meshBlocks(), 0U);
    EXPECT_GT(subject.voxelBlocks(), 0U);
    const BlockGrid& grid = subject.grid();
    const double bound = subject.distance(view);
    EXPECT_LT(bound, subject.reach(view));
    const std::vector<bool> occupied = occupiedBlocks(grid);
    forEachBlock(grid, [&](const glm::uvec3& block) {
        const double away = distanceTo(grid.boxOf(block), view.eye);
        const std::uint8_t owner = subject.blocks()[grid.index(block)];
        EXPECT_EQ(owner, away >= bound ? kVoxelsInPresent : 0) << away << " " << bound;
        // what a mesh may be needed for lies within reach, with all of it
        const core::Box box = grid.boxOf(block);
        const glm::dvec3 most =
            glm::max(glm::abs(box.low - view.eye), glm::abs(box.high - view.eye));
        EXPECT_TRUE(owner != 0 || glm::length(most) < subject.reach(view));
    });
    subject.end();
    for (const std::uint8_t owner : subject.blocks())
        EXPECT_TRUE(owner == 0 || owner == (kVoxelsInFormer | kVoxelsInPresent));
    EXPECT_FALSE(subject.begin(view, {})) << "nothing has changed";
}

TEST_F(HandOverTest, showsVoxelsWhereThereIsNoMeshYetAndTakesThemBack)
{
    HandOver subject = handOver();
    const hierarchy::View view = viewFrom({2.0, 0.7, 2.3});
    subject.begin(view, {});
    EXPECT_EQ(subject.meshBlocks(), 0U);
    const surface::Delta coarse = deltaOf(uniformFront(0));
    subject.apply(coarse);
    subject.begin(view, {});
    EXPECT_EQ(subject.meshBlocks(), 0U) << "six cells are worse than voxels";
    surface::Delta fine = deltaOf(uniformFront(6), 1e-6F);
    for (const surface::ShownCell& cell : coarse.added)
        fine.removed.push_back(cell.id);
    subject.apply(fine);
    subject.begin(view, {});
    EXPECT_GT(subject.meshBlocks(), 0U);
    subject.clearMeshes();
    subject.begin(view, {});
    EXPECT_EQ(subject.meshBlocks(), 0U);
}

TEST_F(HandOverTest, waitsForVoxelsThatAreFineEnough)
{
    HandOver subject = handOver();
    subject.apply(deltaOf(uniformFront(6), 1e-6F));
    const hierarchy::View view = viewFrom({2.0, -1.0, 2.3});
    ASSERT_LT(subject.distance(view), 1.5);
    const std::vector<VoxelDetail> coarse{{tree()[0].entry.key, tree()[0].entry.key.level}};
    subject.begin(view, coarse);
    const std::size_t meshes = subject.meshBlocks();
    EXPECT_GT(meshes, 0U);
    std::vector<VoxelDetail> fine;
    for (const auto& [key, chunk] : chunks())
        if (key.level == 0)
            fine.push_back({key, 0});
    subject.begin(view, fine);
    EXPECT_EQ(subject.meshBlocks(), 0U) << "all of it is further away than the bound";
}

TEST_F(HandOverTest, doesNotGoBackAndForthWithAnEyeThatTrembles)
{
    HandOver subject = handOver();
    subject.apply(deltaOf(uniformFront(6), 1e-6F));
    auto random = tests::random(4);
    const glm::dvec3 eye(2.0, 0.7, 2.3);
    subject.begin(viewFrom(eye), {});
    // by less than the hysteresis of what is nearest to the bound
    const double most = 0.06 * subject.distance(viewFrom(eye));
    std::vector<std::size_t> changes(subject.grid().size(), 0);
    for (int i = 0; i < 50; ++i) {
        const auto shift = [&] { return tests::uniform(random, -most, most) / std::sqrt(3.0); };
        subject.begin(viewFrom(eye + glm::dvec3(shift(), shift(), shift())), {});
        for (std::size_t block = 0; block < changes.size(); ++block) {
            const std::uint8_t owner = subject.blocks()[block];
            changes[block] += owner == 1 || owner == 2 ? 1U : 0U;
        }
    }
    EXPECT_LE(*std::ranges::max_element(changes), 1U);
}

/// What HandOver::begin is to decide, the slow way.
struct Twin {
    const BlockGrid& grid;
    const std::vector<bool>& occupied;
    HandOverSettings settings;
    double voxelEdge;
    std::vector<std::uint8_t> blocks;

    struct Cell {
        core::Box box;
        double error;
    };

    void begin(
        const hierarchy::View& view,
        const std::map<surface::CellId, Cell>& cells,
        const std::vector<VoxelDetail>& details)
    {
        for (std::size_t i = 0; i < blocks.size(); ++i) {
            const glm::uvec3 block(
                i % grid.count.x, i / grid.count.x % grid.count.y, i / grid.count.x / grid.count.y);
            const core::Box box = grid.boxOf(block);
            const double least = voxelEdge / 1024;
            const auto away = [&](const core::Box& of) {
                const glm::dvec3 at = glm::clamp(view.eye, of.low, of.high);
                return std::max(least, glm::distance(at, view.eye));
            };
            int level = 0;
            for (const VoxelDetail& detail : details) {
                const double edge = std::ldexp(256 * voxelEdge, int(detail.part.level));
                const glm::dvec3 low =
                    grid.origin + edge * glm::dvec3(detail.part.x, detail.part.y, detail.part.z);
                const glm::dvec3 centre = box.centre();
                if (glm::all(glm::greaterThan(centre, low)) &&
                    glm::all(glm::lessThan(centre, low + edge)) && occupied[i])
                    level = int(detail.level);
            }
            const double pixels = view.pixelsPerUnit();
            const double voxelError =
                kVoxelError * std::ldexp(voxelEdge, level) * pixels / away(box);
            double meshError = occupied[i] ? kInfinite : 0;
            bool isAny = false;
            for (const auto& [id, cell] : cells) {
                if (glm::any(glm::lessThan(cell.box.high, box.low)) ||
                    glm::any(glm::greaterThanEqual(cell.box.low, box.high)))
                    continue;
                const double error = double(
                    static_cast<float>(cell.error * pixels / std::max(away(cell.box), away(box))));
                meshError = isAny ? std::max(meshError, error) : error;
                isAny = true;
            }
            const bool were = (blocks[i] & kVoxelsInPresent) != 0;
            bool are = false;
            if (voxelError <= settings.pixels * (were ? settings.hysteresis : 1))
                are = true;
            else if (meshError <= settings.meshPixels * (were ? 1 : settings.hysteresis))
                are = false;
            else
                are = were ? voxelError <= settings.hysteresis * meshError
                           : settings.hysteresis * voxelError < meshError;
            blocks[i] = static_cast<std::uint8_t>((were ? 1 : 0) | (are ? 2 : 0));
        }
    }
};

TEST_F(HandOverTest, decidesAsItsRuleSaysOnAnyFlight)
{
    auto random = tests::random(11);
    std::size_t changes = 0;
    for (int trial = 0; trial < tests::trials(4); ++trial) {
        HandOverSettings settings;
        settings.pixels = tests::uniform(random, 0.3, 1.0);
        settings.meshPixels = tests::uniform(random, 0.5, 3.0);
        settings.hysteresis = tests::uniform(random, 1.0, 1.4);
        HandOver subject = handOver(settings);
        const std::vector<bool> occupied = occupiedBlocks(subject.grid());
        Twin twin{
            subject.grid(),
            occupied,
            settings,
            tree().lattice().edge,
            std::vector<std::uint8_t>(subject.grid().size(), 0)};
        hierarchy::Front front = uniformFront(3);
        std::map<surface::CellId, Twin::Cell> cells;
        glm::dvec3 eye(2.0, 0.0, 2.5);
        for (int step = 0; step < 12; ++step) {
            // a few cells come and go
            surface::Delta delta;
            for (const auto& [id, cell] : cells)
                if (tests::below(random, 4) == 0)
                    delta.removed.push_back(id);
            for (const surface::CellId& id : delta.removed)
                cells.erase(id);
            for (int i = 0; i < 3; ++i) {
                const auto diamonds = front.diamondsWithCells();
                front.refine(diamonds[tests::below(random, diamonds.size())].centre);
            }
            front.forEachCell([&](const surface::CellId& id, const hierarchy::Tetrahedron& cell) {
                if (tests::below(random, 3) != 0 || cells.contains(id))
                    return;
                const auto measured = static_cast<float>(tests::uniform(random, 0.0, 0.05));
                const bool isMeasured = tests::below(random, 2) == 0;
                delta.added.push_back(cellOf(id, isMeasured ? measured : 0));
                const double expected = surface::expectedError(cell.level, kLattice, domain());
                const extractor::CellMesh& mesh = *delta.added.back().mesh();
                core::Box box;
                for (const extractor::CellVertex& vertex : mesh.vertices)
                    box.include(domain().worldFromGrid(mesh.gridPosition(vertex)));
                box.low -= tree().lattice().edge;
                box.high += tree().lattice().edge;
                cells[id] = {box, isMeasured ? std::min(expected, double(measured)) : expected};
            });
            subject.apply(delta);
            std::vector<VoxelDetail> details;
            for (voxels::ChunkIndex i = 1; i < tree().size(); ++i)
                if (tree()[i].entry.key.level == 1 && tests::below(random, 2) == 0)
                    details.push_back(
                        {tree()[i].entry.key, static_cast<std::uint32_t>(tests::below(random, 3))});
            const auto step3 = [&] { return tests::uniform(random, -0.4, 0.4); };
            eye += glm::dvec3(step3(), step3() + 0.05, step3());
            const hierarchy::View view = viewFrom(eye);
            const std::vector<std::uint8_t> before(
                subject.blocks().begin(), subject.blocks().end());
            const bool hasChanged = subject.begin(view, details);
            twin.begin(view, cells, details);
            EXPECT_EQ(hasChanged, !std::ranges::equal(before, subject.blocks()));
            std::size_t different = 0;
            for (std::size_t i = 0; i < twin.blocks.size(); ++i) {
                different += twin.blocks[i] != subject.blocks()[i] ? 1U : 0U;
                changes += twin.blocks[i] == 1 || twin.blocks[i] == 2 ? 1U : 0U;
            }
            ASSERT_EQ(different, 0U) << trial << " " << step;
        }
    }
    EXPECT_GT(changes, 100U);
}

TEST_F(HandOverTest, knowsTheOwnersOfBoxes)
{
    HandOver subject = handOver();
    subject.apply(deltaOf(uniformFront(6), 1e-6F));
    subject.begin(viewFrom({2.0, 0.7, 2.3}), {});
    subject.begin(viewFrom({2.2, 1.0, 2.6}), {});
    const BlockGrid& grid = subject.grid();
    auto random = tests::random(5);
    const auto brute = [&](const core::Box& box) {
        Owners owners;
        forEachBlock(grid, [&](const glm::uvec3& block) {
            const glm::uvec3 from = grid.blockAt(box.low);
            const glm::uvec3 to = grid.blockAt(box.high);
            if (glm::any(glm::lessThan(block, from)) || glm::any(glm::greaterThan(block, to)))
                return;
            const std::uint8_t bits = subject.blocks()[grid.index(block)];
            owners.voxels = static_cast<std::uint8_t>(owners.voxels | bits);
            owners.meshes = static_cast<std::uint8_t>(owners.meshes | (~unsigned{bits} & 3U));
        });
        return owners;
    };
    std::array<std::size_t, 16> met{};
    for (int i = 0; i < 400; ++i) {
        const auto place = [&] { return tests::uniform(random, 0.5, 3.5); };
        core::Box box;
        box.include({place(), place(), place()});
        const double size = tests::uniform(random, 0.0, 0.5);
        box.include(box.low + size * glm::dvec3(1.0, 0.7, 0.4));
        const Owners expected = brute(box);
        const Owners owners = subject.ownersOf(box);
        ASSERT_EQ(owners.voxels, expected.voxels);
        ASSERT_EQ(owners.meshes, expected.meshes);
        ++met[std::size_t{owners.voxels} * 4 + owners.meshes];
    }
    EXPECT_GT(met[3], 0U) << "only meshes";
    EXPECT_GT(met[12], 0U) << "only voxels";
    EXPECT_GT(met[15], 0U) << "both";
    // chunks look a little further than their voxels
    for (voxels::ChunkIndex i = 0; i < tree().size(); ++i) {
        core::Box box = tree()[i].box;
        box.low -= 4 * tree().voxelEdge(tree()[i].entry.key.level);
        box.high += 4 * tree().voxelEdge(tree()[i].entry.key.level);
        EXPECT_EQ(
            subject.ownersAround(tree()[i].box, tree()[i].entry.key.level).voxels,
            brute(box).voxels);
    }
}

TEST_F(HandOverTest, refusesWhatMakesNoSense)
{
    const voxels::Chunk* root = &chunks().at(tree()[0].entry.key);
    for (const HandOverSettings& settings :
         {HandOverSettings{.pixels = 0},
          HandOverSettings{.pixels = std::nan("")},
          HandOverSettings{.meshPixels = -1},
          HandOverSettings{.hysteresis = 0.5},
          HandOverSettings{.hysteresis = kInfinite}}) {
        const auto made = HandOver::create(tree(), root, domain(), kLattice, settings);
        ASSERT_FALSE(made);
        EXPECT_EQ(made.error().code, core::ErrorCode::usage);
    }
    EXPECT_FALSE(HandOver::create(tree(), nullptr, domain(), kLattice, {}));
    const auto empty = voxels::ChunkTree::create({}, {});
    auto nothing = HandOver::create(*empty, nullptr, domain(), kLattice, {});
    ASSERT_TRUE(nothing);
    nothing->begin(viewFrom({0, 0, 0}), {});
    HandOver subject = handOver();
    hierarchy::View view = viewFrom({0, 0, 0});
    view.eye.x = std::nan("");
    EXPECT_FALSE(subject.begin(view, {}));
}

} // namespace
} // namespace isofront::render
