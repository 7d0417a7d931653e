#include "isofront/voxels/LevelTransition.h"

#include "ChunkCodec.h"

#include <isofront/core/Assert.h>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>

// Based on: S. Jablonski and T. Martyn, "Real-time rendering of continuous levels of detail for
// sparse voxel octrees", section 7.

namespace isofront::voxels {

namespace {

constexpr auto kFadeDirections = [] {
    std::array<std::array<FadeDirection, 8>, 256> table{};
    for (unsigned children = 0; children < table.size(); ++children)
        table[children] = fadeDirections(static_cast<std::uint8_t>(children));
    return table;
}();

glm::dvec4 linear(std::uint32_t colour)
{
    const auto channel = [&](unsigned shift) {
        const double c = (colour >> shift & 0xffU) / 255.0;
        return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    };
    return {channel(0), channel(8), channel(16), (colour >> 24U) / 255.0};
}

} // namespace

std::vector<TransitionBox>
transitionBoxes(const std::array<std::uint32_t, 3>& parent, std::uint8_t children, double weight)
{
    ISOFRONT_ASSERT(children != 0, "a voxel without children has no finer level");
    std::vector<TransitionBox> boxes;
    boxes.reserve(8);
    const unsigned present = children;
    for (std::uint32_t child = 0; child < 8; ++child) {
        TransitionBox box;
        box.child = child;
        box.isRedundant = (present >> child & 1U) == 0;
        if (box.isRedundant && weight >= 1)
            continue;
        const std::array<int, 3> step = fadeStep(kFadeDirections[children][child]);
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double corner = 2.0 * parent[axis] + (child >> axis & 1U);
            const std::array<double, 2> extent =
                fadeExtent(step[axis], box.isRedundant ? weight : 0);
            box.low[axis] = corner + extent[0];
            box.high[axis] = corner + extent[1];
        }
        boxes.push_back(box);
    }
    return boxes;
}

BlendedLook blended(const FaceAttributes& parent, const FaceAttributes& child, double weight)
{
    const glm::dvec3 own = unpackNormal(child.normal);
    const glm::dvec3 normal = glm::mix(unpackNormal(parent.normal), own, weight);
    const double length = glm::length(normal);
    // shorter, and its direction would be rounding
    constexpr double kShortest = 1e-6;
    return {
        length > kShortest ? normal / length : own,
        glm::mix(linear(parent.colour), linear(child.colour), weight)};
}

core::Result<TransitionNodes> transitionNodes(const Chunk& chunk, const Chunk& parent)
{
    ISOFRONT_ASSERT(
        parent.key == chunk.key.parent(),
        nameOf(parent.key) + " is not the parent of " + nameOf(chunk.key));
    constexpr std::uint32_t kHalf = kChunkEdge / 2;
    const std::uint32_t offset = packPlace(
        kHalf * (chunk.key.x & 1U), kHalf * (chunk.key.y & 1U), kHalf * (chunk.key.z & 1U), 0);
    const auto isInOctant = [&](const Voxel& v) {
        return ((v.place ^ offset) & packPlace(kHalf, kHalf, kHalf, 0)) == 0;
    };

    // where each row of the parent's octant begins
    const auto rowOf = [](std::uint32_t y, std::uint32_t z) { return y + kHalf * z; };
    std::vector<std::uint32_t> rowBegin(std::size_t{kHalf} * kHalf, 0);
    for (std::size_t i = parent.voxels.size(); i-- > 0;)
        if (const Voxel& v = parent.voxels[i]; isInOctant(v))
            rowBegin[rowOf(v.y() % kHalf, v.z() % kHalf)] = static_cast<std::uint32_t>(i);

    TransitionNodes nodes;
    nodes.parents.reserve(chunk.voxels.size());
    std::vector<std::uint8_t> children(parent.voxels.size());
    std::uint32_t row = 0xffffffffU;
    std::uint32_t at = 0;
    for (const Voxel& v : chunk.voxels) {
        if (row != v.order() >> 8U) { // a new one; voxels follow each other along x
            row = v.order() >> 8U;
            at = rowBegin[rowOf(v.y() / 2, v.z() / 2)];
        }
        const std::uint32_t above = offset + packPlace(v.x() / 2, v.y() / 2, v.z() / 2, 0);
        while (at < parent.voxels.size() && parent.voxels[at].order() < above)
            ++at;
        if (at == parent.voxels.size() || parent.voxels[at].order() != above)
            return core::failure(
                core::ErrorCode::badData,
                nameOf(chunk.key) + " has a voxel that its parent doesn't contain: make the model "
                                    "again");
        nodes.parents.push_back(at);
        const std::uint32_t child = (v.x() & 1U) | (v.y() & 1U) << 1U | (v.z() & 1U) << 2U;
        children[at] = static_cast<std::uint8_t>(children[at] | 1U << child);
    }

    for (std::uint32_t i = 0; i < parent.voxels.size(); ++i) {
        const Voxel& v = parent.voxels[i];
        const unsigned present = children[i];
        if (present == 0)
            continue; // of another octant
        const std::array<FadeDirection, 8>& directions = kFadeDirections[present];
        for (std::uint32_t child = 0; child < 8; ++child) {
            if ((present >> child & 1U) != 0)
                continue;
            const auto place = [&](std::uint32_t p, std::uint32_t axis) {
                return 2 * (p % kHalf) + (child >> axis & 1U);
            };
            nodes.redundant.push_back(
                place(v.x(), 0) | place(v.y(), 1) << 8U | place(v.z(), 2) << 16U |
                static_cast<std::uint32_t>(directions[child]) << 24U);
            nodes.parents.push_back(i);
        }
    }
    return nodes;
}

double transitionWeight(double pixels, double mostPixels, double span)
{
    ISOFRONT_ASSERT(mostPixels > 0 && span > 0 && span <= 1, "no range of sizes to change in");
    return std::clamp((2 * pixels / mostPixels - 1) / span, 0.0, 1.0);
}

} // namespace isofront::voxels
