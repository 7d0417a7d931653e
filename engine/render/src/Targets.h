#pragma once

#include <isofront/core/Result.h>
#include <isofront/gpu/Image.h>

#include <cstdint>

namespace isofront::render {

inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kSurfaceFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
inline constexpr VkFormat kPictureFormat = VK_FORMAT_R8G8B8A8_UNORM;
inline constexpr VkFormat kNameFormat = VK_FORMAT_R32_UINT; ///< of voxels
inline constexpr VkFormat kColourFormat = VK_FORMAT_R8G8B8A8_UNORM;

/// The images that a frame is drawn into, all of one size. Depth and surface have samples.
struct Targets {
    gpu::Image depth;   ///< reversed: near plane / distance; 0 where there is nothing
    gpu::Image surface; ///< normal [world] and kind of surface, as mesh.frag.glsl writes them
    gpu::Image shaded;  ///< sRGB, before stair steps are softened
    gpu::Image picture; ///< sRGB, finished
    gpu::Image colours; ///< sRGB, of what has a colour of its own; made when something has

    /// Makes `colours`, if they aren't there.
    core::Result<void> needColours(gpu::Device& device);

    static core::Result<Targets> create(
        gpu::Device& device,
        std::uint32_t width,
        std::uint32_t height,
        VkSampleCountFlagBits samples);
    [[nodiscard]] VkExtent2D extent() const { return picture.extent(); }

private:
    VkSampleCountFlagBits _samples = VK_SAMPLE_COUNT_1_BIT;
};

} // namespace isofront::render
