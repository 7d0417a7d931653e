#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>
#include <isofront/gpu/Handle.h>

#include <cstdint>
#include <span>

namespace isofront::gpu {

/// What differs between our graphics pipelines. Triangles, no blending; viewport, scissor, front
/// face and cull mode are set while recording.
struct GraphicsPipeline {
    std::span<const std::uint32_t> vertexShader;   ///< SPIR-V
    std::span<const std::uint32_t> fragmentShader; ///< SPIR-V; may be empty to draw depth alone
    VkPipelineLayout layout = VK_NULL_HANDLE;
    std::span<const VkVertexInputBindingDescription> vertexBindings;
    std::span<const VkVertexInputAttributeDescription> vertexAttributes;
    std::span<const VkFormat> colourFormats;
    VkFormat depthFormat = VK_FORMAT_UNDEFINED; ///< undefined: neither tested nor written
    bool writesDepth = true;                    ///< false: only tested
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT; ///< of each pixel drawn into
    bool shadesSamples = false; ///< runs the fragment shader for each of them
};

core::Result<Pipeline> makePipeline(Device& device, const GraphicsPipeline& description);

/// @param code  SPIR-V
core::Result<Pipeline>
makeComputePipeline(Device& device, std::span<const std::uint32_t> code, VkPipelineLayout layout);

/// @param constants  bytes that may be pushed to compute shaders, a multiple of 4
core::Result<PipelineLayout>
makePipelineLayout(Device& device, VkDescriptorSetLayout layout, std::uint32_t constants = 0);

/// Sets what `GraphicsPipeline` leaves open. Front faces are counter-clockwise in the picture.
void setRasterState(
    VkCommandBuffer commands,
    VkExtent2D extent,
    VkCullModeFlags cull,
    VkFrontFace front = VK_FRONT_FACE_COUNTER_CLOCKWISE);

} // namespace isofront::gpu
