#include "Samples.h"

#include "Targets.h"

#include <algorithm>
#include <array>
#include <string>

namespace isofront::render {

namespace {

/// One bit for each number.
VkSampleCountFlags possibleSamples(const gpu::Device& device)
{
    constexpr VkImageUsageFlags kRead =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    constexpr VkImageUsageFlags kColour = kRead | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT;
    constexpr VkImageUsageFlags kDepth = kRead | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
    return gpu::sampleCounts(device, kDepthFormat, kDepth) &
           gpu::sampleCounts(device, kSurfaceFormat, kColour) &
           gpu::sampleCounts(device, kNameFormat, kColour) &
           gpu::sampleCounts(device, kColourFormat, kColour);
}

} // namespace

core::Result<void> checkSamples(const gpu::Device& device, int samples)
{
    constexpr std::array kNumbers{1, 4, 8};
    if (std::find(kNumbers.begin(), kNumbers.end(), samples) == kNumbers.end())
        return core::failure(
            core::ErrorCode::usage,
            std::to_string(samples) + " samples a pixel are not possible; use 1, 4 or 8");
    const VkSampleCountFlags possible = possibleSamples(device);
    const auto has = [&](int number) {
        return (possible & static_cast<VkSampleCountFlags>(number)) != 0;
    };
    if (has(samples))
        return {};
    std::string all;
    for (const int number : kNumbers)
        if (has(number))
            all += (all.empty() ? "" : " and ") + std::to_string(number);
    return core::failure(
        core::ErrorCode::noDevice,
        "the graphics device " + device.description().name + " can't draw " +
            std::to_string(samples) + " samples a pixel: it has " + all + "; ask for one of these");
}

std::span<const glm::ivec2> samplePlaces(int samples)
{
    static constexpr std::array kOne{glm::ivec2(8, 8)};
    static constexpr std::array kFour{
        glm::ivec2(6, 2), glm::ivec2(14, 6), glm::ivec2(2, 10), glm::ivec2(10, 14)};
    static constexpr std::array kEight{
        glm::ivec2(9, 5),
        glm::ivec2(7, 11),
        glm::ivec2(13, 9),
        glm::ivec2(5, 3),
        glm::ivec2(3, 13),
        glm::ivec2(1, 7),
        glm::ivec2(11, 15),
        glm::ivec2(15, 1)};
    if (samples == 8)
        return kEight;
    return samples == 4 ? std::span<const glm::ivec2>(kFour) : kOne;
}

} // namespace isofront::render
