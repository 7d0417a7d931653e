#pragma once

#include "PeerModule.h"

#include <isofront/voxels/TriangleModel.h>
#include <isofront/voxels/VoxelRay.h>

#include <glm/vec3.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace isofront::bench {

/// Embree's scene of a model, while it is measured.
///
/// Thread: any number may cast at once.
class EmbreeModel {
public:
    enum class Way {
        single,  ///< one ray after the other
        packets, ///< sixteen at a time, which should have much in common
    };

    /// Coordinates are taken from `origin`, for the sake of floats.
    EmbreeModel(const voxels::TriangleModel& model, const glm::dvec3& origin);
    EmbreeModel(const EmbreeModel&) = delete;
    EmbreeModel& operator=(const EmbreeModel&) = delete;
    ~EmbreeModel();

    /// False where Embree wasn't built in.
    [[nodiscard]] bool isThere() const { return _scene != nullptr; }
    /// That finding triangles takes beside them.
    [[nodiscard]] std::int64_t bytes() const { return _module.memory(_scene); }
    [[nodiscard]] std::vector<peers::EmbreeRay> raysOf(std::span<const voxels::Ray> rays) const;
    void cast(std::span<peers::EmbreeRay> rays, Way way) const;

private:
    const EmbreeModule& _module = embreeModule();
    glm::dvec3 _origin;
    void* _scene = nullptr;
};

} // namespace isofront::bench
