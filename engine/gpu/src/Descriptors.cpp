#include "isofront/gpu/Descriptors.h"

#include "isofront/gpu/Check.h"

#include <isofront/core/Assert.h>

namespace isofront::gpu {

core::Result<DescriptorSets>
DescriptorSets::create(Device& device, std::span<const Binding> bindings, std::uint32_t count)
{
    DescriptorSets sets;
    sets._device = device.handle();
    sets._bindings.assign(bindings.begin(), bindings.end());

    std::vector<VkDescriptorSetLayoutBinding> slots;
    std::vector<VkDescriptorPoolSize> sizes;
    for (std::uint32_t i = 0; i < bindings.size(); ++i) {
        slots.push_back(
            {.binding = i,
             .descriptorType = bindings[i].type,
             .descriptorCount = 1,
             .stageFlags = bindings[i].stages});
        sizes.push_back({bindings[i].type, count});
    }
    const VkDescriptorSetLayoutCreateInfo layoutInfo{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
        .bindingCount = static_cast<std::uint32_t>(slots.size()),
        .pBindings = slots.data()};
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreateDescriptorSetLayout(device.handle(), &layoutInfo, nullptr, &layout),
        "create a descriptor layout");
    sets._layout = {device.handle(), layout};

    const VkDescriptorPoolCreateInfo poolInfo{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
        .maxSets = count,
        .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
        .pPoolSizes = sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreateDescriptorPool(device.handle(), &poolInfo, nullptr, &pool),
        "create a descriptor pool");
    sets._pool = {device.handle(), pool};

    const std::vector<VkDescriptorSetLayout> layouts(count, layout);
    const VkDescriptorSetAllocateInfo info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
        .descriptorPool = pool,
        .descriptorSetCount = count,
        .pSetLayouts = layouts.data()};
    sets._sets.resize(count);
    ISOFRONT_VK(
        vkAllocateDescriptorSets(device.handle(), &info, sets._sets.data()),
        "create descriptor sets");
    return sets;
}

void DescriptorSets::write(std::size_t index, std::span<const Bound> bound) const
{
    ISOFRONT_ASSERT(
        bound.size() == _bindings.size(),
        std::to_string(bound.size()) + " things for " + std::to_string(_bindings.size()) +
            " bindings");
    std::vector<VkDescriptorBufferInfo> buffers(bound.size());
    std::vector<VkDescriptorImageInfo> images(bound.size());
    std::vector<VkWriteDescriptorSet> writes;
    for (std::uint32_t i = 0; i < bound.size(); ++i) {
        VkWriteDescriptorSet write{
            .sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
            .dstSet = _sets[index],
            .dstBinding = i,
            .descriptorCount = 1,
            .descriptorType = _bindings[i].type};
        if (bound[i].buffer != nullptr) {
            buffers[i] = {bound[i].buffer->get(), 0, VK_WHOLE_SIZE};
            write.pBufferInfo = &buffers[i];
        } else {
            ISOFRONT_ASSERT(bound[i].image != nullptr, "a binding is left empty");
            images[i] = {
                bound[i].sampler, bound[i].image->view(), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
            write.pImageInfo = &images[i];
        }
        writes.push_back(write);
    }
    vkUpdateDescriptorSets(
        _device, static_cast<std::uint32_t>(writes.size()), writes.data(), 0, nullptr);
}

core::Result<Sampler> makeSampler(Device& device, VkFilter filter)
{
    const VkSamplerCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
        .magFilter = filter,
        .minFilter = filter,
        .mipmapMode = VK_SAMPLER_MIPMAP_MODE_NEAREST,
        .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
        .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
        .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    VkSampler sampler = VK_NULL_HANDLE;
    ISOFRONT_VK(vkCreateSampler(device.handle(), &info, nullptr, &sampler), "create a sampler");
    return Sampler(device.handle(), sampler);
}

} // namespace isofront::gpu
