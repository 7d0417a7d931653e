#include "EmbreeModel.h"

#include <cstddef>

namespace isofront::bench {

EmbreeModel::EmbreeModel(const voxels::TriangleModel& model, const glm::dvec3& origin)
    : _origin(origin)
{
    if (_module.scene == nullptr)
        return;
    std::vector<float> positions;
    for (const glm::dvec3& p : model.positions)
        for (std::size_t axis = 0; axis < 3; ++axis)
            positions.push_back(static_cast<float>(p[axis] - origin[axis]));
    _scene = _module.scene(positions, model.triangles);
}

EmbreeModel::~EmbreeModel()
{
    if (_scene != nullptr)
        _module.close(_scene);
}

std::vector<peers::EmbreeRay> EmbreeModel::raysOf(std::span<const voxels::Ray> rays) const
{
    std::vector<peers::EmbreeRay> result;
    for (const voxels::Ray& ray : rays) {
        peers::EmbreeRay& r = result.emplace_back();
        for (std::size_t axis = 0; axis < 3; ++axis) {
            r.start[axis] = static_cast<float>(ray.start[axis] - _origin[axis]);
            r.direction[axis] = static_cast<float>(ray.direction[axis]);
        }
    }
    return result;
}

void EmbreeModel::cast(std::span<peers::EmbreeRay> rays, Way way) const
{
    (way == Way::packets ? _module.castPackets : _module.cast)(_scene, rays);
}

} // namespace isofront::bench
