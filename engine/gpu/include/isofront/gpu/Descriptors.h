#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Handle.h>
#include <isofront/gpu/Image.h>

#include <cstdint>
#include <span>
#include <vector>

namespace isofront::gpu {

/// One slot of a descriptor set; slots are numbered in order from 0.
struct Binding {
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    VkShaderStageFlags stages = VK_SHADER_STAGE_FRAGMENT_BIT;
};

/// What goes into a slot: a whole buffer, or an image with its sampler.
struct Bound {
    const Buffer* buffer = nullptr;
    const Image* image = nullptr;
    VkSampler sampler = VK_NULL_HANDLE;
};

/// A layout with sets of exactly that layout. A set is always written whole, because a partly
/// bound set crashes some drivers even where no shader looks at the missing part.
class DescriptorSets {
public:
    DescriptorSets() = default;
    static core::Result<DescriptorSets>
    create(Device& device, std::span<const Binding> bindings, std::uint32_t count);

    [[nodiscard]] VkDescriptorSetLayout layout() const { return _layout.get(); }
    [[nodiscard]] VkDescriptorSet set(std::size_t index) const { return _sets[index]; }
    /// Fills a set that the GPU doesn't use now.
    /// @param bound  one entry for each binding (asserted)
    void write(std::size_t index, std::span<const Bound> bound) const;

private:
    VkDevice _device = VK_NULL_HANDLE;
    std::vector<Binding> _bindings;
    Handle<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout> _layout;
    Handle<VkDescriptorPool, vkDestroyDescriptorPool> _pool;
    std::vector<VkDescriptorSet> _sets;
};

/// A sampler that takes the nearest texel, clamped at the borders; or one that blends four.
core::Result<Sampler> makeSampler(Device& device, VkFilter filter);

} // namespace isofront::gpu
