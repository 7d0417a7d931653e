#include "IndirectDraws.h"

#include <algorithm>
#include <cstdint>
#include <span>

namespace isofront::render {

void issueDraws(
    const gpu::Device& device,
    VkCommandBuffer commands,
    const gpu::Buffer& draws,
    std::size_t first,
    std::size_t count,
    bool indirect)
{
    constexpr std::uint32_t kStride = sizeof(VkDrawIndexedIndirectCommand);
    if (indirect) {
        const std::size_t most = std::max(device.limits().maxDrawIndirectCount, 1U);
        while (count > 0) {
            const std::size_t some = std::min(most, count);
            vkCmdDrawIndexedIndirect(
                commands, draws.get(), first * kStride, static_cast<std::uint32_t>(some), kStride);
            first += some;
            count -= some;
        }
        return;
    }
    const std::span<const VkDrawIndexedIndirectCommand> all{
        reinterpret_cast<const VkDrawIndexedIndirectCommand*>(draws.mapped().data()),
        draws.mapped().size() / kStride};
    for (const VkDrawIndexedIndirectCommand& draw : all.subspan(first, count)) {
        vkCmdDrawIndexed(
            commands,
            draw.indexCount,
            draw.instanceCount,
            draw.firstIndex,
            draw.vertexOffset,
            draw.firstInstance);
    }
}

} // namespace isofront::render
