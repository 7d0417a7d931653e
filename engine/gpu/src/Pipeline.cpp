#include "isofront/gpu/Pipeline.h"

#include "isofront/gpu/Check.h"

#include <array>
#include <vector>

namespace isofront::gpu {

namespace {

using ShaderModule = Handle<VkShaderModule, vkDestroyShaderModule>;

core::Result<ShaderModule> makeShader(Device& device, std::span<const std::uint32_t> code)
{
    const VkShaderModuleCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
        .codeSize = code.size_bytes(),
        .pCode = code.data()};
    VkShaderModule module = VK_NULL_HANDLE;
    ISOFRONT_VK(vkCreateShaderModule(device.handle(), &info, nullptr, &module), "load a shader");
    return ShaderModule(device.handle(), module);
}

VkPipelineShaderStageCreateInfo stageOf(const ShaderModule& shader, VkShaderStageFlagBits stage)
{
    return {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
        .stage = stage,
        .module = shader.get(),
        .pName = "main"};
}

} // namespace

core::Result<Pipeline> makePipeline(Device& device, const GraphicsPipeline& description)
{
    std::vector<ShaderModule> shaders;
    std::vector<VkPipelineShaderStageCreateInfo> stages;
    const std::array code{description.vertexShader, description.fragmentShader};
    constexpr std::array kStages{VK_SHADER_STAGE_VERTEX_BIT, VK_SHADER_STAGE_FRAGMENT_BIT};
    for (std::size_t i = 0; i < code.size(); ++i) {
        if (code[i].empty())
            continue;
        core::Result<ShaderModule> shader = makeShader(device, code[i]);
        if (!shader)
            return tl::unexpected(shader.error());
        stages.push_back(stageOf(*shader, kStages[i]));
        shaders.push_back(std::move(*shader));
    }

    const auto sizeOf = [](const auto& span) { return static_cast<std::uint32_t>(span.size()); };
    const VkPipelineVertexInputStateCreateInfo vertexInput{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = sizeOf(description.vertexBindings),
        .pVertexBindingDescriptions = description.vertexBindings.data(),
        .vertexAttributeDescriptionCount = sizeOf(description.vertexAttributes),
        .pVertexAttributeDescriptions = description.vertexAttributes.data()};
    const VkPipelineInputAssemblyStateCreateInfo assembly{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineViewportStateCreateInfo viewport{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .polygonMode = VK_POLYGON_MODE_FILL,
        .lineWidth = 1.0F};
    const VkPipelineMultisampleStateCreateInfo samples{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = description.samples,
        .sampleShadingEnable = description.shadesSamples ? VK_TRUE : VK_FALSE,
        .minSampleShading = 1.0F};
    const bool depth = description.depthFormat != VK_FORMAT_UNDEFINED;
    const VkPipelineDepthStencilStateCreateInfo depthState{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = depth ? VK_TRUE : VK_FALSE,
        .depthWriteEnable = depth && description.writesDepth ? VK_TRUE : VK_FALSE,
        // Depth is reversed: 1 at the near plane, 0 infinitely far away.
        .depthCompareOp = VK_COMPARE_OP_GREATER};
    const std::vector<VkPipelineColorBlendAttachmentState> attachments(
        description.colourFormats.size(),
        {.colorWriteMask = VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                           VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT});
    const VkPipelineColorBlendStateCreateInfo blend{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = sizeOf(attachments),
        .pAttachments = attachments.data()};
    constexpr std::array kDynamic{
        VK_DYNAMIC_STATE_VIEWPORT,
        VK_DYNAMIC_STATE_SCISSOR,
        VK_DYNAMIC_STATE_CULL_MODE,
        VK_DYNAMIC_STATE_FRONT_FACE};
    const VkPipelineDynamicStateCreateInfo dynamic{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = sizeOf(kDynamic),
        .pDynamicStates = kDynamic.data()};
    const VkPipelineRenderingCreateInfo rendering{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = sizeOf(description.colourFormats),
        .pColorAttachmentFormats = description.colourFormats.data(),
        .depthAttachmentFormat = description.depthFormat};
    const VkGraphicsPipelineCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
        .pNext = &rendering,
        .stageCount = sizeOf(stages),
        .pStages = stages.data(),
        .pVertexInputState = &vertexInput,
        .pInputAssemblyState = &assembly,
        .pViewportState = &viewport,
        .pRasterizationState = &raster,
        .pMultisampleState = &samples,
        .pDepthStencilState = &depthState,
        .pColorBlendState = &blend,
        .pDynamicState = &dynamic,
        .layout = description.layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreateGraphicsPipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
        "build a pipeline");
    return Pipeline(device.handle(), pipeline);
}

core::Result<Pipeline>
makeComputePipeline(Device& device, std::span<const std::uint32_t> code, VkPipelineLayout layout)
{
    const core::Result<ShaderModule> shader = makeShader(device, code);
    if (!shader)
        return tl::unexpected(shader.error());
    const VkComputePipelineCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = stageOf(*shader, VK_SHADER_STAGE_COMPUTE_BIT),
        .layout = layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
        "build a compute pipeline");
    return Pipeline(device.handle(), pipeline);
}

core::Result<PipelineLayout>
makePipelineLayout(Device& device, VkDescriptorSetLayout layout, std::uint32_t constants)
{
    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, constants};
    const VkPipelineLayoutCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
        .setLayoutCount = 1,
        .pSetLayouts = &layout,
        .pushConstantRangeCount = constants > 0 ? 1U : 0U,
        .pPushConstantRanges = &range};
    VkPipelineLayout object = VK_NULL_HANDLE;
    ISOFRONT_VK(
        vkCreatePipelineLayout(device.handle(), &info, nullptr, &object),
        "create a pipeline layout");
    return PipelineLayout(device.handle(), object);
}

void setRasterState(
    VkCommandBuffer commands, VkExtent2D extent, VkCullModeFlags cull, VkFrontFace front)
{
    const VkViewport viewport{
        .width = static_cast<float>(extent.width),
        .height = static_cast<float>(extent.height),
        .maxDepth = 1.0F};
    const VkRect2D scissor{.extent = extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdSetCullMode(commands, cull);
    vkCmdSetFrontFace(commands, front);
}

} // namespace isofront::gpu
