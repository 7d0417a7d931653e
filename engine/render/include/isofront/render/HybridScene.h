#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/HandOver.h>
#include <isofront/render/Renderer.h>
#include <isofront/surface/Surface.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/ChunkStreamer.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <vector>

namespace isofront::render {

/// Reads the mesh that a voxel model was made from; from any thread, once at most. When the token
/// is stopped nobody needs it any more.
using SourceReader = std::function<core::Result<voxels::TriangleModel>(const std::stop_token&)>;

struct HybridSettings {
    /// HandOverSettings::meshPixels is taken from `pixelError`.
    HandOverSettings handOver = {};
    /// How long anything that changes takes to do so [s], see TransitionClock; 0: no time.
    double transitionSeconds = 0;
    /// As the surface was made with: what it is asked for is this, within the reach that the
    /// hand-over leaves to it.
    double pixelError = 2;
    surface::DetailSettings detail = {};
    int latticeSize = 16;          ///< of its cells
    double updateMilliseconds = 2; ///< surface::UpdateBudget
    /// The cache is never larger than the renderer's pool; voxels are as fine as the hand-over
    /// needs them to be.
    voxels::StreamingSettings streaming = {};
    VoxelWay way = VoxelWay::automatic;
    /// For voxels without a surface: their source is shown where the finest of them are larger than
    /// `streaming.voxelPixels`. Empty for none. The renderer must be of `voxelDomain`, and show the
    /// colours of meshes if they are to be seen (RendererOptions::meshColours). It is read when it
    /// is needed for the first time. `handOver.pixels` is taken from the voxels' bound.
    SourceReader source = {};
};

/// What one frame did.
struct HybridFrame {
    std::uint64_t number = 0; ///< of the frames drawn, from 1 on; 0 without voxels
    FrameStats drawn;
    UploadStats meshes;
    double surfaceMilliseconds = 0; ///< for the surface's update
    double voxelMilliseconds = 0;   ///< for the hand-over and the choice of chunks
    std::size_t meshBlocks = 0;     ///< blocks with voxels that are the meshes' now
    std::size_t voxelBlocks = 0;    ///< and the voxels'
    std::uint64_t uploadedVoxelBytes = 0;
    std::uint64_t residentVoxelBytes = 0; ///< on the device
    std::size_t missingChunks = 0;        ///< that the view needs
    double coarsening = 1;                ///< voxels::ChunkFrame
    /// What the nearest voxels may cover, as far as the cache lets them be so small [px]; 0 without
    /// voxels.
    double voxelPixels = 0;
    float transition = 1;                   ///< weight of the present picture
    std::uint64_t sourceBytes = 0;          ///< of the voxels' source on the device
    std::uint64_t sourceHostBytes = 0;      ///< and on the host, nearly
    bool sourceIsFull = false;              ///< not all that the view needs of it has room
    std::optional<core::Error> sourceError; ///< why there is none; in one frame
    std::vector<core::Error> damaged;       ///< chunks found so in this frame
    /// With the same view the next frame looks the same.
    bool isComplete = false;
};

/// A surface, near as extracted meshes and far as surface voxels of the same field, in one picture.
/// Or a voxel model alone, near as the triangles that it was made from.
///
/// It leads what takes part in a frame: the clock of all transitions, the surface and its deltas,
/// the hand-over, the streamer of chunks, the renderer. Either the surface or the voxels may be
/// missing.
///
/// Thread: one at a time; the same that calls the renderer and the surface.
class HybridScene {
public:
    /// @param renderer  of the surface's domain, without cells and chunks; must outlive the scene
    /// @param surface   null for voxels alone; nothing handed out of it yet; must outlive the scene
    /// @param model     voxels of the same field in the same place; null for meshes alone
    /// @param jobs      where chunks are loaded; not null
    /// The renderer holds changes from then on, if transitions take time: Renderer::holdChanges.
    /// @return what HandOver::create, ChunkStreamer::create and Renderer::chunkCacheBytes say;
    /// usage
    ///         for a source beside a surface, or a renderer of another domain than it needs
    static core::Result<HybridScene> create(
        Renderer& renderer,
        surface::Surface* surface,
        std::shared_ptr<const voxels::ChunkStore> model,
        std::shared_ptr<core::Jobs> jobs,
        const HybridSettings& settings);
    HybridScene(HybridScene&&) noexcept;
    HybridScene& operator=(HybridScene&&) noexcept;
    ~HybridScene();

    /// Draws the next frame. Never waits for an extraction or for the store.
    /// @param seconds  its time, from anywhere
    /// @return as Renderer::apply and Renderer::draw
    core::Result<HybridFrame>
    frame(const hierarchy::View& view, const Scene& scene, double seconds);

    /// Draws once more what the last frame showed, as another view sees it, and changes nothing: to
    /// tell what a movement changes from what a change of detail does. Not before the first frame.
    /// Waits for the picture.
    core::Result<FrameStats> redraw(const hierarchy::View& view, const Scene& scene);

    /// Draws until all that the view needs is there: for still pictures and first frames.
    /// @param progress  of the meshes, called with a share in [0, 1], now and then
    /// @param stop      ends it early, with `interrupted`
    core::Result<HybridFrame> settle(
        const hierarchy::View& view,
        const Scene& scene,
        const std::function<void(double)>& progress = {},
        const std::stop_token& stop = {});

    /// Null for meshes alone or voxels alone.
    [[nodiscard]] const HandOver* handOver() const;

private:
    struct Parts;
    explicit HybridScene(std::unique_ptr<Parts> parts);

    std::unique_ptr<Parts> _parts;
};

} // namespace isofront::render
