#include "BlockScene.h"
#include "ChunkCodec.h"
#include "support/Random.h"
#include "support/TemporaryFolder.h"

#include <isofront/voxels/ChunkTree.h>

#include <gtest/gtest.h>

#include <set>

namespace isofront::voxels {
namespace {

TEST(ChunkTree, knowsWhereEverythingIs)
{
    const auto store = tests::city(4, 3, true).store();
    const auto tree = ChunkTree::create(store->model().lattice, *store->directory());
    ASSERT_TRUE(tree) << tree.error().message;
    ASSERT_EQ(tree->size(), store->keys().size());
    EXPECT_EQ((*tree)[0].entry.key, (ChunkKey{3, 0, 0, 0}));
    std::size_t children = 0;
    for (ChunkIndex i = 0; i < tree->size(); ++i) {
        const ChunkTree::Node& node = (*tree)[i];
        EXPECT_EQ(tree->find(node.entry.key), i);
        const auto chunk = store->get(node.entry.key);
        EXPECT_EQ(node.entry, entryOf(**chunk));
        core::Box tight;
        const double edge = tree->voxelEdge(node.entry.key.level);
        for (const Voxel& voxel : (*chunk)->voxels) {
            const glm::dvec3 low(
                node.entry.key.x * 256.0 + voxel.x(),
                node.entry.key.y * 256.0 + voxel.y(),
                node.entry.key.z * 256.0 + voxel.z());
            tight.include(edge * low);
            tight.include(edge * (low + glm::dvec3(1)));
        }
        EXPECT_EQ(tight.low, node.box.low);
        EXPECT_EQ(tight.high, node.box.high);
        bool isLeaf = true;
        for (std::uint32_t which = 0; which < 8; ++which) {
            const ChunkIndex child = node.children[which];
            EXPECT_EQ(
                child,
                node.entry.key.level == 0 ? kNoChunk : tree->find(node.entry.key.child(which)));
            if (child == kNoChunk)
                continue;
            isLeaf = false;
            ++children;
            EXPECT_LT(i, child);
            EXPECT_EQ((*tree)[child].parent, i);
        }
        EXPECT_EQ(node.isLeaf, isLeaf);
    }
    EXPECT_EQ(children + 1, tree->size());
    EXPECT_EQ(tree->find({2, 9, 0, 0}), kNoChunk);
}

TEST(ChunkTree, refusesWhatIsNoTree)
{
    const auto store = tests::city(3, 2, false).store();
    const VoxelLattice lattice = store->model().lattice;
    const std::vector<ChunkEntry> directory = *store->directory();
    const auto refused = [&](std::vector<ChunkEntry> entries, VoxelLattice where) {
        const auto tree = ChunkTree::create(where, entries);
        return !tree && tree.error().code == core::ErrorCode::badData;
    };
    for (std::size_t i = 0; i < directory.size(); ++i) {
        std::vector<ChunkEntry> other = directory;
        other.push_back(other[i]);
        EXPECT_TRUE(refused(other, lattice)) << "twice";
        other = directory;
        other[i].voxels = 0;
        EXPECT_TRUE(refused(other, lattice)) << "empty";
        other[i].voxels = 0x1000001;
        EXPECT_TRUE(refused(other, lattice)) << "more than there is room for";
        for (const std::uint32_t parents :
             {0U, (directory[i].voxels - 1) / 8, directory[i].voxels + 1, 0xffffffffU}) {
            other = directory;
            other[i].parents = parents;
            EXPECT_TRUE(refused(other, lattice)) << parents << " parents";
        }
        other = directory;
        other[i].low[1] = 200;
        other[i].high[1] = 100;
        EXPECT_TRUE(refused(other, lattice)) << "turned inside out";
        other = directory;
        other[i].key.x |= 4U >> other[i].key.level;
        EXPECT_TRUE(refused(other, lattice)) << "outside";
        other = directory;
        other[i].key.level += 3;
        EXPECT_TRUE(refused(other, lattice)) << "no such level";
        if (directory[i].key.level > 0) {
            other = directory;
            other.erase(other.begin() + static_cast<std::ptrdiff_t>(i));
            EXPECT_TRUE(refused(other, lattice)) << "an orphan";
        }
    }
    VoxelLattice other = lattice;
    for (const std::uint32_t levels : {0U, 10U, 0xffffffffU}) {
        other.levels = levels;
        EXPECT_TRUE(refused(directory, other));
    }
    other = lattice;
    other.edge = std::numeric_limits<double>::quiet_NaN();
    EXPECT_TRUE(refused(directory, other));
    EXPECT_EQ(ChunkTree::create(lattice, {})->size(), 0U);
}

TEST(ChunkDirectory, isKeptByAllStores)
{
    const auto original = tests::city(3, 2, false).store();
    const std::vector<ChunkEntry> expected = *original->directory();
    tests::TemporaryFolder folder;
    for (const bool isFolder : {false, true}) {
        const auto path = folder.path(isFolder ? "folder" : "file");
        {
            auto store = isFolder ? createFolderStore(path) : createStore(path);
            ASSERT_TRUE(store) << store.error().message;
            for (const ChunkEntry& entry : expected)
                ASSERT_FALSE((*store)->put(**original->get(entry.key)));
            ASSERT_FALSE((*store)->finish(original->model()));
        }
        const auto store = isFolder ? openFolderStore(path) : openStore(path);
        ASSERT_TRUE(store) << store.error().message;
        const auto directory = (*store)->directory();
        ASSERT_TRUE(directory) << directory.error().message;
        EXPECT_EQ(*directory, expected);
    }
}

TEST(ChunkDirectory, isRefusedIfItIsDamaged)
{
    const auto store = tests::city(3, 2, false).store();
    const std::vector<std::byte> bytes = encoded(*store->directory());
    EXPECT_EQ(*decodedDirectory(bytes), *store->directory());
    auto random = tests::random(8);
    for (int trial = 0; trial < tests::trials(1000); ++trial) {
        std::vector<std::byte> other = bytes;
        if (trial % 4 == 0)
            other.resize(tests::below(random, bytes.size()));
        else
            other[tests::below(random, trial % 2 == 0 ? 16 : bytes.size())] ^=
                static_cast<std::byte>(1 + tests::below(random, 255));
        const auto read = decodedDirectory(other);
        ASSERT_FALSE(read) << trial;
        EXPECT_EQ(read.error().code, core::ErrorCode::badData);
    }
}

TEST(ChunkView, neverMissesWhatCanBeSeen)
{
    auto random = tests::random(9);
    int seen = 0;
    int missed = 0;
    for (int trial = 0; trial < tests::trials(3000); ++trial) {
        const auto any = [&](double most) {
            return glm::dvec3(
                tests::uniform(random, -most, most),
                tests::uniform(random, -most, most),
                tests::uniform(random, -most, most));
        };
        tests::BlockCamera camera;
        const double scale = trial % 2 == 0 ? 1 : 1e7; // far from the origin, too
        camera.eye = any(5) + glm::dvec3(scale - 1, 0, 1 - scale);
        camera.forward = any(1);
        camera.fieldOfView = tests::uniform(random, 0.3, 2.0);
        const ChunkView view = camera.view();
        ASSERT_TRUE(view.isValid());
        core::Box box;
        const glm::dvec3 centre = camera.eye + any(8);
        box.include(centre);
        box.include(centre + any(3));
        bool isSeen = false;
        double nearest = 1e30;
        for (int i = 0; i < 50; ++i) {
            const glm::dvec3 p(
                tests::uniform(random, box.low.x, box.high.x),
                tests::uniform(random, box.low.y, box.high.y),
                tests::uniform(random, box.low.z, box.high.z));
            nearest = std::min(nearest, glm::length(p - camera.eye));
            const glm::dvec3 ahead = glm::normalize(camera.forward);
            const glm::dvec3 right = glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
            const double far = glm::dot(p - camera.eye, ahead);
            const double tangent = std::tan(0.5 * camera.fieldOfView);
            isSeen |= far > camera.nearest &&
                      std::abs(glm::dot(p - camera.eye, right)) <
                          far * tangent * camera.width / camera.height &&
                      std::abs(glm::dot(p - camera.eye, glm::cross(right, ahead))) < far * tangent;
        }
        EXPECT_LE(view.distanceTo(box), std::max(nearest, view.nearest) * (1 + 1e-9));
        EXPECT_TRUE(view.mayShow(box) || !isSeen);
        seen += isSeen ? 1 : 0;
        missed += view.mayShow(box) ? 0 : 1;
    }
    EXPECT_GT(seen, 100);
    EXPECT_GT(missed, 100);
    ChunkView view = tests::BlockCamera().view();
    view.eye.y = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(view.isValid());
    EXPECT_FALSE(ChunkView{.pixelsPerUnit = 0}.isValid());
    EXPECT_FALSE(ChunkView{.nearest = 0}.isValid());
    EXPECT_TRUE(ChunkView{}.isValid());
}

} // namespace
} // namespace isofront::voxels
