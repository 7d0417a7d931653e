#include "PatternPass.h"

#include "shared/pattern.h"

#include <isofront/gpu/Barriers.h>
#include <isofront/gpu/Descriptors.h>
#include <isofront/shaders/voxelPatternComp.h>
#include <isofront/shaders/voxelPatternSamplesComp.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>

namespace isofront::render {

namespace {

constexpr std::uint32_t kThreads = 256;     ///< of a group
constexpr std::uint32_t kPixelsEach = 16;   ///< of a thread, in small pictures
constexpr std::uint32_t kMostGroups = 1024; ///< in larger ones each has more

constexpr gpu::Use kSampledInCompute{
    VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT,
    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};

} // namespace

core::Result<PatternPass>
PatternPass::create(gpu::Device& device, std::uint32_t slots, VkSampleCountFlagBits samples)
{
    PatternPass pass;
    core::Result<gpu::Sampler> sampler = gpu::makeSampler(device, VK_FILTER_NEAREST);
    if (!sampler)
        return tl::unexpected(sampler.error());
    pass._nearest = std::move(*sampler);
    constexpr gpu::Binding kImage{
        VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_COMPUTE_BIT};
    constexpr gpu::Binding kBuffer{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT};
    core::Result<Stage> stage = makeStage(
        device, std::array{kImage, kImage, kBuffer, kBuffer}, slots, sizeof(shared::PatternStep));
    if (!stage)
        return tl::unexpected(stage.error());
    pass._stage = std::move(*stage);
    using Code = std::span<const std::uint32_t>;
    core::Result<gpu::Pipeline> pipeline = gpu::makeComputePipeline(
        device,
        samples == VK_SAMPLE_COUNT_1_BIT ? Code(voxelPatternComp) : Code(voxelPatternSamplesComp),
        pass._stage.layout.get());
    if (!pipeline)
        return tl::unexpected(pipeline.error());
    pass._pipeline = std::move(*pipeline);

    struct Wanted {
        gpu::Buffer Slot::*buffer;
        std::size_t bytes;
        VkBufferUsageFlags usage;
        gpu::MemoryKind kind;
    };
    constexpr auto kStorage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    constexpr std::array kWanted{
        Wanted{
            &Slot::found,
            sizeof(shared::Pattern),
            kStorage | VK_BUFFER_USAGE_TRANSFER_SRC_BIT,
            gpu::MemoryKind::device},
        Wanted{
            &Slot::partial, kMostGroups * sizeof(shared::uvec2), kStorage, gpu::MemoryKind::device},
        Wanted{
            &Slot::seen,
            sizeof(shared::Pattern),
            VK_BUFFER_USAGE_TRANSFER_DST_BIT,
            gpu::MemoryKind::readback}};
    pass._slots.resize(slots);
    for (Slot& slot : pass._slots) {
        for (const Wanted& wanted : kWanted) {
            core::Result<gpu::Buffer> buffer =
                gpu::Buffer::create(device, wanted.bytes, wanted.usage, wanted.kind);
            if (!buffer)
                return tl::unexpected(buffer.error());
            slot.*wanted.buffer = std::move(*buffer);
        }
    }
    return pass;
}

void PatternPass::record(
    VkCommandBuffer commands,
    std::size_t slot,
    const gpu::Image& names,
    const gpu::Image& depth) const
{
    const Slot& mine = _slots[slot];
    _stage.sets.write(
        slot,
        std::array{
            gpu::Bound{.image = &names, .sampler = _nearest.get()},
            gpu::Bound{.image = &depth, .sampler = _nearest.get()},
            gpu::Bound{.buffer = &mine.found},
            gpu::Bound{.buffer = &mine.partial}});
    gpu::imageBarrier(commands, names, gpu::use::kSampledInFragment, kSampledInCompute);
    gpu::imageBarrier(commands, depth, gpu::use::kDepthWrite, kSampledInCompute);
    bindStage(commands, _pipeline, _stage, slot, VK_PIPELINE_BIND_POINT_COMPUTE);
    const VkExtent2D extent = names.extent();
    const std::uint64_t pixels = std::uint64_t{extent.width} * extent.height;
    constexpr std::uint64_t kEach = std::uint64_t{kThreads} * kPixelsEach;
    const auto groups = static_cast<std::uint32_t>(
        std::min<std::uint64_t>((pixels + kEach - 1) / kEach, kMostGroups));
    for (const std::uint32_t stage :
         {shared::kPatternOfGroups, shared::kPatternOfAll, shared::kPatternPixels}) {
        const shared::PatternStep step{stage, extent.width, extent.height, groups};
        vkCmdPushConstants(
            commands, _stage.layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof step, &step);
        vkCmdDispatch(commands, stage == shared::kPatternOfAll ? 1 : groups, 1, 1);
        gpu::memoryBarrier(
            commands,
            gpu::use::kComputeStorage,
            stage == shared::kPatternPixels ? gpu::use::kTransferRead : gpu::use::kComputeStorage);
    }
    gpu::imageBarrier(commands, depth, kSampledInCompute, gpu::use::kDepthWrite);
    gpu::imageBarrier(commands, names, kSampledInCompute, gpu::use::kSampledInFragment);
    const VkBufferCopy all{.size = sizeof(shared::Pattern)};
    vkCmdCopyBuffer(commands, mine.found.get(), mine.seen.get(), 1, &all);
    gpu::memoryBarrier(commands, gpu::use::kTransferWrite, gpu::use::kHostRead);
}

std::optional<PatternPass::Found> PatternPass::found(std::size_t slot) const
{
    shared::Pattern pattern{};
    std::memcpy(&pattern, _slots[slot].seen.mapped().data(), sizeof pattern);
    if (pattern.pixels == 0)
        return std::nullopt;
    return Found{
        .node = {.id = pattern.nearest.y, .depth = pattern.nearest.x, .pixels = pattern.pixels},
        .voxelPixels = pattern.voxelPixels};
}

} // namespace isofront::render
