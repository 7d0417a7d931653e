#include "SunMap.h"

#include "Targets.h"

#include <limits>
#include <utility>

namespace isofront::render {

namespace {

/// Of a map that was to be drawn, but nobody has said that it was.
constexpr int kNotDrawn = std::numeric_limits<int>::max();

core::Result<gpu::Image> makeMap(gpu::Device& device, std::uint32_t texels)
{
    return gpu::Image::create(
        device,
        texels,
        texels,
        kDepthFormat,
        VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT);
}

} // namespace

core::Result<SunMap> SunMap::create(gpu::Device& device, int texels)
{
    core::Result<gpu::Image> map = makeMap(device, static_cast<std::uint32_t>(texels));
    if (!map)
        return tl::unexpected(map.error());
    return SunMap(std::move(*map));
}

core::Result<void> SunMap::keepPresent(gpu::Device& device, const SunBox& box)
{
    if (!_former) {
        core::Result<gpu::Image> map = makeMap(device, _present.extent().width);
        if (!map)
            return tl::unexpected(map.error());
        _former = std::move(*map);
    }
    std::swap(_present, *_former);
    _formerBox = box;
    return {};
}

core::Result<bool> SunMap::update(
    gpu::Device& device,
    const hierarchy::Domain& domain,
    const SunBox& wanted,
    int interval,
    float weight)
{
    const SunBox kept = _box.seenFrom(domain, wanted.eye);
    const bool fades = weight < 1;
    const bool begins = std::exchange(_begins, false) && fades;
    if (!fades)
        _formerBox.casts = false;
    _formerBox = _formerBox.seenFrom(domain, wanted.eye);
    if (wanted.casts && !begins && _age < interval && kept.isNear(wanted)) {
        _box = kept;
        ++_age;
        return false;
    }
    if (begins) {
        _formerBox.casts = false;
        if (kept.casts && _age != kNotDrawn) {
            if (core::Result<void> done = keepPresent(device, kept); !done)
                return tl::unexpected(done.error());
        }
    }
    // What counts along other axes can't be read with the present map's.
    _formerBox.casts = _formerBox.casts && _formerBox.isAlike(wanted);
    _box = wanted;
    // Until it is really drawn, it must not be kept.
    _age = kNotDrawn;
    return wanted.casts;
}

} // namespace isofront::render
