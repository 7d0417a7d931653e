#pragma once

#include "GridMesh.h"

#include <isofront/gpu/Device.h>
#include <isofront/render/Renderer.h>

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace isofront::test {

/// A device under validation, synchronisation included; any message fails the test.
class RenderFixture : public testing::Test {
protected:
    void SetUp() override;
    void TearDown() override;

    std::unique_ptr<render::Renderer> renderer(
        const hierarchy::Domain& domain, const render::RendererOptions& options = smallOptions());
    static render::RendererOptions smallOptions();
    /// Applies a delta that must fit.
    static void show(render::Renderer& renderer, const surface::Delta& delta);

    struct Shot {
        core::Image image;
        std::vector<float> depth;
        render::FrameStats stats;

        bool operator==(const Shot& other) const
        {
            return image.rgba == other.image.rgba && depth == other.depth;
        }
        [[nodiscard]] float depthAt(int x, int y) const
        {
            return depth[static_cast<std::size_t>(y * image.width + x)];
        }
    };
    static Shot
    shoot(render::Renderer& renderer, const hierarchy::View& view, const render::Scene& scene = {});

    std::unique_ptr<gpu::Device> device;
};

/// A view of a small picture from one point to another.
hierarchy::View
lookingAt(const glm::dvec3& eye, const glm::dvec3& target, int width = 160, int height = 120);

/// The ray through the middle of a pixel, not normalised; 1 along the forward direction.
glm::dvec3 pixelRay(const hierarchy::View& view, int x, int y);

} // namespace isofront::test
