#pragma once

#include "DetailOptions.h"
#include "MeshOptions.h"
#include "SourceArguments.h"

#include <isofront/core/Result.h>
#include <isofront/gpu/Device.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/Renderer.h>
#include <isofront/surface/Surface.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

namespace isofront::cli {

/// What pictures of a source need: a device, a renderer on it, and how things are to look.
struct Studio {
    std::unique_ptr<gpu::Device> device;
    std::unique_ptr<render::Renderer> renderer;
    render::Scene scene;
};

struct StudioOptions {
    bool hasSource = false;                          ///< of a model of voxels: it may be shown
    std::string device;                              ///< see gpu::DeviceOptions
    int width = 1280;                                ///< [px]
    int height = 720;                                ///< [px]
    int samples = 1;                                 ///< see render::RendererOptions
    int shadowInterval = 1;                          ///< frames between two shadow maps
    std::size_t meshBytes = std::size_t{512} << 20U; ///< what meshes may take on the device
    std::uint64_t voxelBytes = 128U << 20U;          ///< and voxels, if there are any
};

/// Errors: noDevice if there is none that fits, resourceLimit if it has too little memory.
core::Result<Studio> openStudio(const Source& source, const StudioOptions& options);

/// From where a box just fills a picture.
/// @param forward, up  of length 1
glm::dvec3 placeBefore(
    const core::Box& box,
    const glm::dvec3& target,
    const glm::dvec3& forward,
    const glm::dvec3& up,
    double fovDegrees,
    int width,
    int height);

/// Looks at where a volume has a surface, from as near as all of it fits the picture; the direction
/// stays, and so does the target if it is given.
/// @param isovalue  of the source's own values
void frameSurface(
    Source& source, double isovalue, bool keepsTarget, double fovDegrees, int width, int height);

/// A view of so many pixels from one point to another, upright if it can be.
/// @param up  of length 1
hierarchy::View viewTo(
    const glm::dvec3& eye,
    const glm::dvec3& target,
    double fovDegrees,
    int width,
    int height,
    const glm::dvec3& up = {0, 0, 1});

/// The surface of a source as a viewer needs it.
surface::SurfaceOptions surfaceOptions(
    const Source& source,
    double isovalue,
    int lattice,
    double filter,
    double pixelError,
    bool closed,
    const MeshOptions& mesh,
    const DetailRequest& detail);

} // namespace isofront::cli
