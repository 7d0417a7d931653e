#include "MeshBlocks.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

namespace isofront::volume {

MeshBlocks::MeshBlocks(const glm::dvec3& size, double reach)
    : _margin(static_cast<int>(std::ceil(reach / kEdge))),
      _size(glm::ivec3(glm::floor(size / double{kEdge})) + 1 + 2 * _margin),
      _touched(
          static_cast<std::size_t>(_size.x) * static_cast<std::size_t>(_size.y) *
          static_cast<std::size_t>(_size.z))
{
}

std::size_t MeshBlocks::indexOf(const glm::ivec3& block) const
{
    const auto along = [](int i) { return static_cast<std::size_t>(i); };
    return (along(block.z) * along(_size.y) + along(block.y)) * along(_size.x) + along(block.x);
}

void MeshBlocks::add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c)
{
    // A triangle is halved until its box is hardly larger than itself.
    const glm::dvec3 low = glm::min(a, glm::min(b, c));
    const glm::dvec3 high = glm::max(a, glm::max(b, c));
    const glm::dvec3 extent = high - low;
    if (std::max({extent.x, extent.y, extent.z}) > kEdge) {
        const std::array<glm::dvec3, 3> corners = {a, b, c};
        std::size_t longest = 0; // edge from this corner to the next one
        double most = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 edge = corners[(i + 1) % 3] - corners[i];
            const double length = glm::dot(edge, edge);
            if (length > most) {
                most = length;
                longest = i;
            }
        }
        const glm::dvec3& from = corners[longest];
        const glm::dvec3& to = corners[(longest + 1) % 3];
        const glm::dvec3& apex = corners[(longest + 2) % 3];
        const glm::dvec3 middle = 0.5 * (from + to);
        add(from, middle, apex);
        add(middle, to, apex);
        return;
    }
    const auto blockAt = [&](const glm::dvec3& place) {
        return glm::clamp(
            glm::ivec3(glm::floor(place / double{kEdge})) + _margin, glm::ivec3(0), _size - 1);
    };
    const glm::ivec3 first = blockAt(low);
    const glm::ivec3 last = blockAt(high);
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x)
                _touched[indexOf({x, y, z})] = true;
}

std::uint64_t MeshBlocks::countWithinReach() const
{
    // A box of blocks contains the ball of the reach; it is the product of its three axes.
    std::vector<bool> within = _touched;
    for (glm::length_t axis = 0; axis < 3; ++axis) {
        glm::ivec3 lines = _size;
        lines[axis] = 1;
        glm::ivec3 step(0);
        step[axis] = 1;
        for (int z = 0; z < lines.z; ++z)
            for (int y = 0; y < lines.y; ++y)
                for (int x = 0; x < lines.x; ++x) {
                    const std::size_t line = indexOf({x, y, z});
                    const std::size_t stride = indexOf(step);
                    const auto at = [&](int i) {
                        return line + static_cast<std::size_t>(i) * stride;
                    };
                    std::vector<bool> touched(static_cast<std::size_t>(_size[axis]));
                    for (int i = 0; i < _size[axis]; ++i)
                        touched[static_cast<std::size_t>(i)] = within[at(i)];
                    int next = 0; // the first block that isn't decided
                    for (int i = 0; i < _size[axis]; ++i) {
                        if (!touched[static_cast<std::size_t>(i)])
                            continue;
                        const int last = std::min(i + _margin[axis], _size[axis] - 1);
                        for (next = std::max(next, i - _margin[axis]); next <= last; ++next)
                            within[at(next)] = true;
                    }
                }
    }
    return static_cast<std::uint64_t>(std::ranges::count(within, true));
}

} // namespace isofront::volume
