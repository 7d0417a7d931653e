#pragma once

#include "Stage.h"
#include "Targets.h"
#include "isofront/render/Scene.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Buffer.h>
#include <isofront/gpu/Pipeline.h>

#include <cstdint>
#include <functional>
#include <span>

namespace isofront::render {

/// The passes of a frame with their pipelines. Each begins with the barriers that it needs.
///
/// First the mesh writes depth and normals; then every pixel is shaded once; then stair steps are
/// softened. So the cost of shading doesn't grow with the number of triangles.
class Passes {
public:
    /// @param slots  how many frames may be in flight; each has its descriptor sets
    /// @param samples  of the targets
    /// @param coloured  whether meshes have colours: RendererOptions::meshColours
    static core::Result<Passes>
    create(gpu::Device& device, std::uint32_t slots, VkSampleCountFlagBits samples, bool coloured);

    /// Points the descriptor sets of a slot, which the GPU must be done with, to its things.
    /// @param colours  of what has a colour of its own; any image if nothing in the frame has
    /// @param formerShadowMap  of the former picture; may be the present one's
    void bind(
        std::size_t slot,
        const gpu::Buffer& frame,
        const gpu::Buffer& cells,
        const gpu::Buffer& owners,
        const Targets& targets,
        const gpu::Image& colours,
        const gpu::Image& shadowMap,
        const gpu::Image& formerShadowMap) const;

    /// What a pass over the mesh needs to know.
    struct MeshDraw {
        const gpu::Buffer* meshes = nullptr; ///< vertices and indices
        /// Four bytes for each vertex of `meshes`; null if meshes have no colours.
        const gpu::Buffer* colours = nullptr;
        VkCullModeFlags cull = VK_CULL_MODE_BACK_BIT;
        VkFrontFace front = VK_FRONT_FACE_COUNTER_CLOCKWISE;
        std::function<void(VkCommandBuffer)> issue; ///< records the draws
        /// Records the draws of cells that are in one of two pictures only; empty if there are
        /// none.
        std::function<void(VkCommandBuffer)> issueFading;
    };
    /// The same mesh as the sun sees it.
    /// @param others  records what else casts shadows
    void drawShadows(
        VkCommandBuffer commands,
        std::size_t slot,
        const gpu::Image& map,
        const MeshDraw& draw,
        const std::function<void()>& others) const;
    /// Instead of `drawShadows`, in a frame without shadows.
    static void skipShadows(VkCommandBuffer commands, const gpu::Image& map);
    void drawMeshes(
        VkCommandBuffer commands,
        std::size_t slot,
        const Targets& targets,
        const MeshDraw& draw) const;
    /// @param last  true if nothing comes after: it then writes the finished picture
    /// @param hasColours  whether a pass has written the targets' colours
    void shade(
        VkCommandBuffer commands,
        std::size_t slot,
        const Targets& targets,
        Look look,
        bool last,
        bool hasColours) const;
    void antialias(VkCommandBuffer commands, std::size_t slot, const Targets& targets) const;
    /// Makes the finished picture ready to be copied.
    static void finish(VkCommandBuffer commands, const Targets& targets);

private:
    static void fillScreen(
        VkCommandBuffer commands,
        const Stage& stage,
        const gpu::Pipeline& pipeline,
        std::size_t slot,
        const gpu::Image& target);

    gpu::Sampler _nearest, _linear;
    Stage _mesh, _shade, _antialias;
    gpu::Pipeline _shadowPipeline, _meshPipeline, _fadingPipeline, _terrainPipeline,
        _studioPipeline, _antialiasPipeline;
};

} // namespace isofront::render
