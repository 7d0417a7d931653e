#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/Renderer.h>
#include <isofront/voxels/ChunkStreamer.h>

#include <cstdint>
#include <memory>
#include <string>

namespace isofront::gpu {
class Device;
}

namespace isofront::bench {

class WaitingJobs;

/// What a frame took, and what it was.
struct StudioFrame {
    double wall = 0;   ///< from choosing chunks to the finished picture [s]
    double cpu = 0;    ///< processor time of it, all threads, those of a driver in software too [s]
    double gpu = 0;    ///< of its passes, by the device's clock [s]
    double update = 0; ///< processor time of choosing chunks and places [s]
    std::size_t chunks = 0;
    std::size_t tests = 0;    ///< chunks that only test whether they are hidden
    std::uint64_t voxels = 0; ///< of the chunks drawn
    std::uint64_t uploadBytes = 0;
    std::uint64_t residentBytes = 0;
    std::uint64_t wantedBytes = 0;
    std::size_t missing = 0;
    double coarsening = 1;
    bool isComplete = false;
};

/// Draws a streamed model of voxels, frame by frame. Chunks are read between the frames, so that
/// no time is of disks: what is measured has been brought to the host before, as in the evaluation
/// of Chajdas et al.
///
/// Thread: one at a time.
class VoxelStudio {
public:
    struct Settings {
        int width = 1280;
        int height = 720;
        glm::dvec3 up{0, 0, 1};
        /// Cache, uploads and form are overruled.
        voxels::StreamingSettings streaming{};
        std::uint64_t poolBytes = 128ULL << 20U;
        std::uint64_t uploadBytes = 0; ///< for a frame; 0: any number
        render::VoxelWay way = render::VoxelWay::automatic;
        bool antialias = false; ///< softens stair steps afterwards
        int samples = 1;        ///< of each pixel
    };

    /// @return noDevice without a device that draws voxels; what renderer and streamer say
    static core::Result<std::unique_ptr<VoxelStudio>>
    create(std::shared_ptr<const voxels::ChunkStore> store, const Settings& settings);
    ~VoxelStudio();
    VoxelStudio(const VoxelStudio&) = delete;
    VoxelStudio& operator=(const VoxelStudio&) = delete;

    /// A view of this studio's pictures.
    [[nodiscard]] hierarchy::View
    view(const glm::dvec3& eye, const glm::dvec3& target, double fieldOfView) const;

    /// Draws the next frame, and waits for it.
    core::Result<StudioFrame> next(const hierarchy::View& view);
    /// Draws frames until all that a view needs is there and nothing more becomes known of what is
    /// hidden; returns the last one.
    core::Result<StudioFrame> settle(const hierarchy::View& view);

    [[nodiscard]] render::Renderer& renderer() { return *_renderer; }
    [[nodiscard]] const render::Scene& scene() const { return _scene; }
    /// How the device calls itself.
    [[nodiscard]] std::string deviceName() const;

private:
    VoxelStudio() = default;

    Settings _settings;
    std::unique_ptr<gpu::Device> _device; ///< outlives the renderer
    std::unique_ptr<render::Renderer> _renderer;
    std::shared_ptr<WaitingJobs> _loading;
    std::unique_ptr<voxels::ChunkStreamer> _streamer;
    voxels::VoxelLattice _lattice;
    render::Scene _scene;
    std::uint64_t _frame = 0;
};

} // namespace isofront::bench
