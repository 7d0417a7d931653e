#include "Models.h"
#include "support/Random.h"

#include <isofront/voxels/ChunkDirectory.h>
#include <isofront/voxels/LevelTransition.h>
#include <isofront/voxels/Voxelization.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <memory>

namespace isofront::voxels {
namespace {

constexpr std::array<std::uint32_t, 3> kOrigin{0, 0, 0};

double volumeOf(const TransitionBox& box)
{
    const glm::dvec3 size = box.high - box.low;
    return size.x * size.y * size.z;
}

glm::dvec3 cornerOf(std::uint32_t child)
{
    return {child & 1U, child >> 1U & 1U, child >> 2U & 1U};
}

TEST(FadeDirections, leadToTheNearestSiblingThatStays)
{
    for (unsigned children = 1; children < 256; ++children) {
        const auto directions = fadeDirections(static_cast<std::uint8_t>(children));
        for (std::uint32_t child = 0; child < 8; ++child) {
            const auto step = fadeStep(directions[child]);
            const glm::dvec3 target = cornerOf(child) + glm::dvec3(step[0], step[1], step[2]);
            const auto reached = static_cast<std::uint32_t>(target.x + 2 * target.y + 4 * target.z);
            ASSERT_NE(children >> reached & 1U, 0U);
            ASSERT_EQ(target, cornerOf(reached)) << "within the parent";
            if ((children >> child & 1U) != 0) {
                ASSERT_EQ(directions[child], kNoFade);
                continue;
            }
            for (std::uint32_t other = 0; other < 8; ++other)
                if ((children >> other & 1U) != 0) {
                    const int away = std::popcount(child ^ other);
                    const int chosen = std::popcount(child ^ reached);
                    ASSERT_LE(chosen, away);
                    if (chosen == away) {
                        ASSERT_LE(reached, other);
                    }
                }
        }
    }
    static_assert(fadeDirections(1)[7] == 0);  // (-1, -1, -1)
    static_assert(fadeDirections(1)[1] == 12); // (-1, 0, 0)
    static_assert(fadeDirections(128)[0] == 26);
    for (FadeDirection code = 0; code < 27; ++code) {
        const auto step = fadeStep(code);
        EXPECT_EQ(step[0] + 1 + 3 * (step[1] + 1) + 9 * (step[2] + 1), code);
    }
}

TEST(TransitionBoxes, areTheParentAtFirstTheChildrenAtLastAndClosedInBetween)
{
    const std::array<std::uint32_t, 3> parent{5, 0, 65'535};
    const glm::dvec3 low(10, 0, 131'070);
    for (unsigned children = 1; children < 256; ++children) {
        const auto mask = static_cast<std::uint8_t>(children);
        const int count = std::popcount(children);
        double before = 9;
        for (int step = 0; step <= 32; ++step) {
            const double w = step / 32.0;
            const auto boxes = transitionBoxes(parent, mask, w);
            double volume = 0;
            for (const TransitionBox& box : boxes) {
                const glm::dvec3 slot = low + cornerOf(box.child);
                volume += volumeOf(box);
                // in its own cube, so that no two overlap
                ASSERT_TRUE(glm::all(glm::greaterThanEqual(box.low, slot)));
                ASSERT_TRUE(glm::all(glm::lessThanEqual(box.high, slot + glm::dvec3(1))));
                ASSERT_EQ(box.isRedundant, (children >> box.child & 1U) == 0);
                if (!box.isRedundant || step == 0) {
                    ASSERT_EQ(box.low, slot);
                    ASSERT_EQ(box.high, slot + glm::dvec3(1));
                }
                if (!box.isRedundant)
                    continue;
                // a cube that touches the sibling that absorbs it, at every weight
                const auto direction = fadeStep(fadeDirections(mask)[box.child]);
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    ASSERT_EQ(box.high[axis] - box.low[axis], 1 - w);
                    if (direction[axis] < 0) {
                        ASSERT_EQ(box.low[axis], slot[axis]);
                    }
                    if (direction[axis] > 0) {
                        ASSERT_EQ(box.high[axis], slot[axis] + 1);
                    }
                    if (direction[axis] == 0) {
                        ASSERT_EQ(box.low[axis] + box.high[axis], 2 * slot[axis] + 1);
                    }
                }
            }
            ASSERT_DOUBLE_EQ(volume, count + (8 - count) * std::pow(1 - w, 3));
            ASSERT_LE(volume, before);
            before = volume;
            ASSERT_EQ(boxes.size(), step == 32 ? static_cast<std::size_t>(count) : 8U);
        }
    }
    // the figures of the specification, of one, four and seven children
    const auto share = [](std::uint8_t children, double w) {
        double volume = 0;
        for (const TransitionBox& box : transitionBoxes(kOrigin, children, w))
            volume += volumeOf(box);
        return volume / 8;
    };
    EXPECT_NEAR(share(0x10, 0.5), 0.2344, 5e-5);
    EXPECT_NEAR(share(0x0f, 0.5), 0.5625, 5e-5);
    EXPECT_NEAR(share(0x7f, 0.5), 0.8906, 5e-5);
    EXPECT_EQ(share(0x01, 1), 0.125);
    EXPECT_EQ(share(0xff, 0.3), 1);
}

TEST(TransitionBoxes, areTheSameForAxesInAnyOrder)
{
    // but for equally near siblings, of which the lower is taken
    const auto swapped = [](std::uint32_t bits) {
        return (bits & 1U) << 1U | (bits >> 1U & 1U) | (bits & 4U);
    };
    for (unsigned children = 1; children < 256; ++children) {
        unsigned other = 0;
        for (std::uint32_t child = 0; child < 8; ++child)
            other |= (children >> child & 1U) << swapped(child);
        const auto a = fadeDirections(static_cast<std::uint8_t>(children));
        const auto b = fadeDirections(static_cast<std::uint8_t>(other));
        for (std::uint32_t child = 0; child < 8; ++child) {
            const auto sizeOf = [](FadeDirection d) {
                const auto step = fadeStep(d);
                return std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
            };
            EXPECT_EQ(sizeOf(a[child]), sizeOf(b[swapped(child)]));
        }
    }
}

TEST(BlendedLook, goesFromTheParentsToTheChilds)
{
    const FaceAttributes parent{packNormal(glm::dvec3(1, 0, 0)), 0xff0000ffU};
    const FaceAttributes child{packNormal(glm::dvec3(0, 1, 0)), 0x80ff0000U};
    EXPECT_EQ(blended(parent, child, 0).normal, glm::dvec3(1, 0, 0));
    EXPECT_EQ(blended(parent, child, 0).colour, glm::dvec4(1, 0, 0, 1));
    EXPECT_EQ(blended(parent, child, 1).normal, glm::dvec3(0, 1, 0));
    EXPECT_EQ(blended(parent, child, 1).colour, glm::dvec4(0, 0, 1, 128 / 255.0));
    const BlendedLook half = blended(parent, child, 0.5);
    EXPECT_NEAR(half.normal.x, std::sqrt(0.5), 1e-12);
    EXPECT_NEAR(half.normal.y, std::sqrt(0.5), 1e-12);
    EXPECT_EQ(half.colour.x, 0.5);
    const FaceAttributes back{packNormal(glm::dvec3(-1, 0, 0)), 0};
    EXPECT_EQ(blended(parent, back, 0.5).normal, glm::dvec3(-1, 0, 0));
}

const tests::KeptChunks& sphere()
{
    static const std::unique_ptr<tests::KeptChunks> kept = [] {
        auto chunks = std::make_unique<tests::KeptChunks>();
        const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
        EXPECT_TRUE(voxelize(tests::hillySphere(40, 10, 1.5), {.resolution = 300}, *chunks, *jobs));
        return chunks;
    }();
    return *kept;
}

TEST(TransitionNodes, areTheMissingChildrenWithTheirParents)
{
    std::size_t chunks = 0;
    for (const auto& [key, chunk] : sphere().chunks) {
        const auto above = sphere().chunks.find(key.parent());
        if (above == sphere().chunks.end())
            continue;
        ++chunks;
        const Chunk& parent = above->second;
        const auto made = transitionNodes(chunk, parent);
        ASSERT_TRUE(made) << made.error().message;
        const TransitionNodes& nodes = *made;
        ASSERT_EQ(nodes.parents.size(), chunk.voxels.size() + nodes.redundant.size());

        // which children each parent has, looked up one by one
        const auto placeInParent = [&](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
            return packPlace(
                (key.x & 1U) * 128 + x / 2,
                (key.y & 1U) * 128 + y / 2,
                (key.z & 1U) * 128 + z / 2,
                0);
        };
        std::map<std::uint32_t, unsigned> children; // by order of the parent
        for (std::size_t i = 0; i < chunk.voxels.size(); ++i) {
            const Voxel& v = chunk.voxels[i];
            const std::uint32_t order = placeInParent(v.x(), v.y(), v.z());
            ASSERT_EQ(parent.voxels.at(nodes.parents[i]).order(), order);
            children[order] |= 1U << ((v.x() & 1U) | (v.y() & 1U) << 1U | (v.z() & 1U) << 2U);
        }
        std::size_t next = 0;
        for (const auto& [order, mask] : children) {
            const auto directions = fadeDirections(static_cast<std::uint8_t>(mask));
            for (std::uint32_t child = 0; child < 8; ++child) {
                if ((mask >> child & 1U) != 0)
                    continue;
                ASSERT_LT(next, nodes.redundant.size());
                const Voxel node{nodes.redundant[next], 0};
                ASSERT_EQ(placeInParent(node.x(), node.y(), node.z()), order);
                ASSERT_EQ((node.x() & 1U) | (node.y() & 1U) << 1U | (node.z() & 1U) << 2U, child);
                ASSERT_EQ(node.place >> 24U, directions[child]);
                ASSERT_EQ(
                    parent.voxels.at(nodes.parents[chunk.voxels.size() + next]).order(), order);
                ++next;
            }
        }
        ASSERT_EQ(next, nodes.redundant.size());
        // known before the chunk is read
        ASSERT_EQ(entryOf(chunk).parents, children.size());
        ASSERT_EQ(entryOf(chunk).redundant(), next);
    }
    EXPECT_GE(chunks, 4U);
}

TEST(TransitionNodes, refuseAVoxelWithoutAParent)
{
    const Chunk parent{{1, 0, 0, 0}, {{packPlace(128, 0, 0, 0), 0}}, {}};
    EXPECT_TRUE(transitionNodes({{0, 1, 0, 0}, {{packPlace(1, 1, 1, 0), 0}}, {}}, parent));
    for (const std::uint32_t place :
         {packPlace(2, 0, 0, 0), packPlace(0, 2, 0, 0), packPlace(255, 255, 255, 0)}) {
        const auto nodes = transitionNodes({{0, 1, 0, 0}, {{place, 0}}, {}}, parent);
        ASSERT_FALSE(nodes);
        EXPECT_EQ(nodes.error().code, core::ErrorCode::badData);
        EXPECT_NE(nodes.error().message.find("chunk 1, 0, 0 of level 0"), std::string::npos);
    }
    EXPECT_FALSE(transitionNodes({{0, 0, 0, 0}, {{packPlace(0, 0, 0, 0), 0}}, {}}, parent));
    EXPECT_TRUE(transitionNodes({{0, 0, 0, 0}, {}, {}}, parent)->parents.empty());
}

/// A picture of boxes seen along z: how near each pixel is, and how bright.
struct Picture {
    static constexpr int kEdge = 210; // pixels; boxes don't end at their borders
    std::vector<double> nearness = std::vector<double>(kEdge * kEdge, -1);
    std::vector<double> light = std::vector<double>(kEdge * kEdge, 0);

    void add(const TransitionBox& box, double scale, const BlendedLook& look)
    {
        const auto first = [&](double low) {
            return std::clamp(static_cast<int>(std::ceil(low * scale - 0.5)), 0, kEdge);
        };
        for (int y = first(box.low.y); y < first(box.high.y); ++y)
            for (int x = first(box.low.x); x < first(box.high.x); ++x) {
                const auto pixel = static_cast<std::size_t>(x + kEdge * y);
                if (box.high.z <= nearness[pixel])
                    continue;
                nearness[pixel] = box.high.z;
                light[pixel] = 0.5 + 0.5 * look.normal.x;
            }
    }
    [[nodiscard]] double differenceTo(const Picture& other) const
    {
        double sum = 0;
        for (std::size_t i = 0; i < light.size(); ++i)
            sum += std::abs(light[i] - other.light[i]);
        return sum;
    }
};

TEST(Transition, changesPicturesLittleByLittleAndIsTheSameBothWays)
{
    tests::KeptChunks kept;
    const auto jobs = core::makeJobs(core::JobsBackend::threads, 2);
    ASSERT_TRUE(voxelize(tests::hillySphere(30, 10, 2), {.resolution = 30}, kept, *jobs));
    // one chunk; its parent's voxels are made here, normals as the mean of the children's
    const Chunk& chunk = kept.chunks.begin()->second;
    Chunk parent{chunk.key.parent(), {}, {}};
    std::map<std::uint32_t, glm::dvec3> normals;
    for (const Voxel& v : chunk.voxels)
        normals[packPlace(v.x() / 2, v.y() / 2, v.z() / 2, 0)] += unpackNormal(v.normal);
    for (const auto& [place, normal] : normals)
        parent.voxels.push_back({place, packNormal(normal)});
    const TransitionNodes nodes = *transitionNodes(chunk, parent);

    const auto picture = [&](double w) {
        Picture result;
        const double scale = Picture::kEdge / 31.0;
        for (std::size_t i = 0; i < nodes.parents.size(); ++i) {
            const bool isRedundant = i >= chunk.voxels.size();
            const Voxel node =
                isRedundant ? Voxel{nodes.redundant[i - chunk.voxels.size()], 0} : chunk.voxels[i];
            TransitionBox box;
            const glm::dvec3 corner(node.x(), node.y(), node.z());
            const auto step =
                fadeStep(isRedundant ? static_cast<FadeDirection>(node.place >> 24U) : kNoFade);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                const auto extent = fadeExtent(step[axis], isRedundant ? w : 0);
                box.low[axis] = corner[axis] + extent[0];
                box.high[axis] = corner[axis] + extent[1];
            }
            const FaceAttributes above{parent.voxels[nodes.parents[i]].normal, 0};
            const FaceAttributes own = isRedundant ? above : FaceAttributes{node.normal, 0};
            result.add(box, scale, blended(above, own, w));
        }
        return result;
    };
    constexpr int kSteps = 32;
    std::vector<Picture> up;
    for (int step = 0; step <= kSteps; ++step)
        up.push_back(picture(step / static_cast<double>(kSteps)));
    const double whole = up.front().differenceTo(up.back());
    EXPECT_GT(whole, 100);
    for (std::size_t step = 1; step < up.size(); ++step)
        EXPECT_LT(up[step - 1].differenceTo(up[step]), whole / 8) << step;
    for (int step = kSteps; step >= 0; --step)
        EXPECT_EQ(
            picture(1 - (kSteps - step) / static_cast<double>(kSteps))
                .differenceTo(up[static_cast<std::size_t>(step)]),
            0);
    // at the ends, exactly the two levels
    Picture coarse;
    for (const Voxel& v : parent.voxels) {
        const glm::dvec3 low = 2.0 * glm::dvec3(v.x(), v.y(), v.z());
        coarse.add({low, low + glm::dvec3(2)}, Picture::kEdge / 31.0, {unpackNormal(v.normal)});
    }
    EXPECT_LT(coarse.differenceTo(up.front()), 1e-9);
    Picture fine;
    for (const Voxel& v : chunk.voxels) {
        const glm::dvec3 low(v.x(), v.y(), v.z());
        fine.add({low, low + glm::dvec3(1)}, Picture::kEdge / 31.0, {unpackNormal(v.normal)});
    }
    EXPECT_LT(fine.differenceTo(up.back()), 1e-9);
}

TEST(TransitionWeight, meetsThatOfTheNextLevelWhereOneReplacesTheOther)
{
    for (const double span : {0.25, 0.5, 1.0}) {
        EXPECT_EQ(transitionWeight(2, 2, span), 1) << "it is about to be replaced";
        EXPECT_EQ(transitionWeight(1, 2, span), 0) << "it has just replaced";
        EXPECT_EQ(transitionWeight(0, 2, span), 0);
        EXPECT_EQ(transitionWeight(1e9, 2, span), 1);
        double before = 0;
        for (double pixels = 1; pixels <= 2; pixels += 1 / 64.0) {
            const double w = transitionWeight(pixels, 2, span);
            EXPECT_GE(w, before);
            EXPECT_LE(w - before, 1 / (64 * span) + 1e-12);
            before = w;
        }
    }
}

} // namespace
} // namespace isofront::voxels
