#include "Culling.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>

namespace isofront::render {

void visibleInto(
    std::span<const StoredCell> cells,
    const GridView& view,
    std::vector<std::uint32_t>& order,
    std::uint32_t pictures)
{
    std::array<glm::dvec3, 4> reach{};
    for (std::size_t i = 0; i < reach.size(); ++i)
        reach[i] = glm::abs(view.sides[i]);

    // Non-negative floats order like their bits, so one word holds distance and index.
    std::vector<std::uint64_t> keys;
    keys.reserve(cells.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
        if (cells[i].indexCount == 0 || (cells[i].pictures & pictures) == 0)
            continue;
        const glm::dvec3 low(cells[i].low - view.eye);
        const glm::dvec3 high(cells[i].high - view.eye);
        const glm::dvec3 centre = 0.5 * (low + high);
        const glm::dvec3 half = 0.5 * (high - low);
        bool visible = true;
        for (std::size_t side = 0; side < reach.size() && visible; ++side)
            visible = glm::dot(view.sides[side], centre) + glm::dot(reach[side], half) +
                          view.offsets[side] >=
                      0;
        if (!visible)
            continue;
        const auto distance = static_cast<float>(glm::length(view.worldFromGrid * centre));
        keys.push_back((std::uint64_t{std::bit_cast<std::uint32_t>(distance)} << 32U) | i);
    }
    std::sort(keys.begin(), keys.end());
    order.resize(keys.size());
    std::transform(keys.begin(), keys.end(), order.begin(), [](std::uint64_t key) {
        return static_cast<std::uint32_t>(key);
    });
}

namespace {

core::Box worldBoxOf(const StoredCell& cell, const hierarchy::Domain& domain)
{
    core::Box box;
    for (unsigned corner = 0; corner < 8; ++corner)
        box.include(domain.worldFromGrid(
            {(corner & 1U) != 0 ? cell.high.x : cell.low.x,
             (corner & 2U) != 0 ? cell.high.y : cell.low.y,
             (corner & 4U) != 0 ? cell.high.z : cell.low.z}));
    return box;
}

} // namespace

void picturesInto(
    std::span<const StoredCell> cells,
    const hierarchy::Domain& domain,
    const HandOver* handOver,
    std::uint32_t shown,
    std::vector<std::uint32_t>& order,
    std::vector<std::uint32_t>& pictures)
{
    pictures.resize(cells.size());
    for (const std::uint32_t index : order) {
        const StoredCell& cell = cells[index];
        pictures[index] = cell.pictures & shared::kInBoth;
        if (handOver == nullptr)
            continue;
        const Owners owners = handOver->ownersOf(worldBoxOf(cell, domain));
        pictures[index] &= owners.meshes;
        if ((pictures[index] & owners.voxels & shown) != 0)
            pictures[index] |= shared::kLooksUp;
    }
    std::erase_if(order, [&](std::uint32_t index) { return (pictures[index] & shown) == 0; });
}

std::size_t moveFadingLast(
    std::span<const std::uint32_t> pictures, std::uint32_t shown, std::vector<std::uint32_t>& order)
{
    const auto first = std::stable_partition(order.begin(), order.end(), [&](std::uint32_t cell) {
        return !isFading(pictures[cell], shown);
    });
    return static_cast<std::size_t>(order.end() - first);
}

std::uint32_t picturesShown(float weight)
{
    return (weight > 0 ? shared::kInPresent : 0) | (weight < 1 ? shared::kInFormer : 0);
}

} // namespace isofront::render
