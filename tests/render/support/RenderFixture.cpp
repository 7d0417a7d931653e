#include "RenderFixture.h"

#include <glm/geometric.hpp>

#include <cmath>

namespace isofront::test {

void RenderFixture::SetUp()
{
    auto created = gpu::Device::create({.validation = true});
    ASSERT_TRUE(created) << created.error().message;
    device = std::move(*created);
}

void RenderFixture::TearDown()
{
    if (!device)
        return;
    for (const std::string& message : device->validationMessages())
        ADD_FAILURE() << message;
}

render::RendererOptions RenderFixture::smallOptions()
{
    render::RendererOptions options;
    options.width = 160;
    options.height = 120;
    options.poolBytes = 8U << 20U;
    options.slabBytes = 64U << 10U;
    return options;
}

std::unique_ptr<render::Renderer>
RenderFixture::renderer(const hierarchy::Domain& domain, const render::RendererOptions& options)
{
    auto created = render::Renderer::create(*device, domain, options);
    EXPECT_TRUE(created) << created.error().message;
    return std::move(*created);
}

void RenderFixture::show(render::Renderer& renderer, const surface::Delta& delta)
{
    const auto stats = renderer.apply(delta);
    ASSERT_TRUE(stats) << stats.error().message;
}

RenderFixture::Shot RenderFixture::shoot(
    render::Renderer& renderer, const hierarchy::View& view, const render::Scene& scene)
{
    Shot shot;
    const auto stats = renderer.draw(view, scene);
    EXPECT_TRUE(stats) << stats.error().message;
    auto image = renderer.readImage();
    auto depth = renderer.readDepth();
    EXPECT_TRUE(image && depth);
    shot.stats = *stats;
    shot.image = std::move(*image);
    shot.depth = std::move(*depth);
    EXPECT_EQ(shot.image.width, view.width);
    EXPECT_EQ(shot.image.height, view.height);
    EXPECT_EQ(shot.depth.size() * 4, shot.image.rgba.size());
    return shot;
}

hierarchy::View lookingAt(const glm::dvec3& eye, const glm::dvec3& target, int width, int height)
{
    hierarchy::View view;
    view.eye = eye;
    view.forward = target - eye;
    const glm::dvec3 forward = glm::normalize(view.forward);
    if (std::abs(forward.z) > 0.95)
        view.up = {1, 0, 0};
    view.width = width;
    view.height = height;
    return view;
}

glm::dvec3 pixelRay(const hierarchy::View& view, int x, int y)
{
    const glm::dvec3 forward = glm::normalize(view.forward);
    const glm::dvec3 right = glm::normalize(glm::cross(forward, view.up));
    const glm::dvec3 up = glm::cross(right, forward);
    const double scale = 1.0 / view.pixelsPerUnit();
    return forward + (x + 0.5 - 0.5 * view.width) * scale * right -
           (y + 0.5 - 0.5 * view.height) * scale * up;
}

} // namespace isofront::test
