#pragma once

#include <isofront/core/Image.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>
#include <isofront/render/Scene.h>
#include <isofront/render/Voxels.h>
#include <isofront/surface/Delta.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isofront::gpu {
class Device;
}

namespace isofront::render {

struct RendererOptions {
    int width = 1280; ///< of the first picture [px]; later ones follow their views
    int height = 720;
    /// All memory for meshes [bytes], at least one slab; taken at once. What doesn't fit is
    /// refused.
    std::uint64_t poolBytes = 256ULL << 20U;
    /// The pool's grain [bytes], rounded up to vertices. Larger: less waste for large meshes, more
    /// to move when slabs are emptied.
    std::uint32_t slabBytes = 384U << 10U;
    /// How many frames the CPU may run ahead of the GPU, at least 1. More: smoother, later, and
    /// removed meshes keep their memory longer.
    int framesInFlight = 2;
    /// Of each pixel: 1, 4 or 8, as far as the device has them. More smooth all outlines, of meshes
    /// and of voxels drawn in either way, and cost time and memory by their number; light is
    /// computed more than once only where a pixel's samples differ. Their mean is taken of light as
    /// it is displayed.
    int samples = 1;
    int shadowMapSize = 2048; ///< along a side, >= 16 [texels]: finer shadows, 4 bytes each
    /// All memory for voxels [bytes], at least a mebibyte; taken at once when the first chunks are
    /// added. No more than shaders can see in one buffer, which is 128 MiB with some drivers.
    std::uint64_t voxelPoolBytes = 128ULL << 20U;
    /// Whether the attributes of meshes (extractor::CellMesh) are colours that they are shown with:
    /// 8-bit sRGB red, green, blue and opacity, red lowest; with an opacity of 0, none. Costs four
    /// bytes for each twelve of the pool.
    bool meshColours = false;
    /// Uploads through staging buffers even where the GPU's memory could be written directly.
    bool forceStaging = false;
    /// Issues draws one by one even where one indirect call could do it.
    bool forceDirectDraws = false;
};

/// What a delta cost.
struct UploadStats {
    std::size_t cellsAdded = 0;
    std::size_t cellsRemoved = 0;
    std::uint64_t uploadedBytes = 0;
    std::uint64_t movedBytes = 0; ///< inside the pool, to empty sparse slabs
    double cpuMilliseconds = 0;
    bool skippedFade = false; ///< changes were held, but shown at once for want of room
};

/// What one pass cost on the GPU.
struct PassTime {
    const char* name = "";
    double milliseconds = 0;
};

struct FrameStats {
    double cpuMilliseconds = 0;  ///< to cull, record and submit; without waiting for the GPU
    double gpuMilliseconds = 0;  ///< of the last frame that is complete; 0 if there is none yet
    std::uint64_t triangles = 0; ///< in the cells drawn
    std::uint64_t shadowTriangles = 0; ///< in the cells that may cast shadows, drawn once more
    std::size_t draws = 0;
    std::size_t cellsDrawn = 0;
    std::size_t cellsFading = 0; ///< of these, in one of the two pictures of a transition only
    std::size_t cellsCulled = 0;
    std::uint64_t uploadedBytes = 0; ///< by the deltas since the last frame
    std::uint64_t poolBytesUsed = 0; ///< of the mesh pool, meshes on their way out included
    /// Of meshes that deltas have removed, but that transitions still show: what a surface is to be
    /// told in UpdateBudget::hostBytes.
    std::uint64_t fadingBytes = 0;
    std::uint64_t deviceBytes = 0; ///< all device memory held, by everything on the device
    VoxelStats voxels;
};

/// Shows the mesh of a surface: keeps it on the GPU, step by step with the surface's deltas, and
/// draws it from any place.
///
/// The mesh has no cracks on screen: vertices are placed relative to the eye in integers, so that
/// the copies of a vertex in neighbouring cells fall onto the same spot to the last bit, at any
/// distance from any origin.
///
/// Thread: one at a time. The device must outlive it.
class Renderer {
public:
    /// @return usage if the options make no sense; noDevice if the device doesn't have so many
    ///         samples; resourceLimit or noDevice as the device says
    static core::Result<std::unique_ptr<Renderer>> create(
        gpu::Device& device, const hierarchy::Domain& domain, const RendererOptions& options = {});
    ~Renderer();
    Renderer(const Renderer&) = delete;
    Renderer& operator=(const Renderer&) = delete;

    /// Takes one step: all of the delta, or on failure nothing. The next frame shows it, unless
    /// changes are held.
    ///
    /// @return resourceLimit if the meshes don't fit into the pool; usage if the delta removes a
    /// cell
    ///         that isn't there or adds one twice; badData if a mesh contradicts itself
    ///
    /// Blocks only if the pool is so full that it must wait for frames in flight.
    core::Result<UploadStats> apply(const surface::Delta& delta);
    /// From now on deltas wait, one upon the other, until the next transition begins, and meshes
    /// that they remove stay until no picture shows them. Where the pool has no room for that, all
    /// changes are shown at once instead.
    /// @param hold  false, as in the beginning: whatever waits is shown, and what fades has gone
    void holdChanges(bool hold);
    /// What was present becomes the former picture, and what waits becomes the present one. What
    /// only the picture before them showed is let go. See TransitionClock.
    ///
    /// Between the two, Scene::transition decides, pixel by pixel. Each pixel shows what it would
    /// show if its picture were drawn alone: so there are no holes and no double surfaces between.
    /// Shadows take part from the next frame on, if it shows the former picture; what the sun sees
    /// of that is kept, in a second map, until a frame shows the present one alone.
    void beginTransition();
    /// Forgets all cells, at once.
    void clear();
    /// Cells that are shown after all deltas, those that wait included.
    [[nodiscard]] std::size_t cellCount() const;

    /// Brings chunks of a voxel model to the device, all or on failure none. Nothing is drawn that
    /// `draw` isn't told to draw. Returns how many bytes that took.
    ///
    /// @return resourceLimit if they don't fit into the pool; usage if one is there already;
    /// badData
    ///         if one is empty or its colours don't fit its voxels; noDevice if the device can't
    ///         draw voxels; usage if chunks were streamed and not cleared
    /// Blocks only if the pool is so full that it must wait for frames in flight.
    core::Result<std::uint64_t> addChunks(std::span<const voxels::Chunk> chunks);
    /// Brings what is needed to draw chunks on their way between levels, all or on failure none;
    /// their chunks must be there. Removed together with them. Returns how many bytes that took.
    /// @return resourceLimit if they don't fit into the pool; usage if one is there already, or its
    ///         chunk isn't; badData if it doesn't fit the chunk's voxels
    core::Result<std::uint64_t> addTransitions(std::span<const VoxelTransition> transitions);
    /// Forgets chunks. Those that aren't there are passed over.
    void removeChunks(std::span<const voxels::ChunkKey> keys);
    /// Forgets all chunks, added and streamed. Needed before another streamer's first frame, and
    /// before chunks are added where some were streamed. Waits for the frames in flight.
    core::Result<void> clearChunks();

    /// How large a streamer's cache may be [bytes]: the whole pool. Fails as `addChunks` does.
    core::Result<std::uint64_t> chunkCacheBytes();
    /// Makes the copies of a streamed frame; `draw` is then given its draws. Every frame must be
    /// applied, in order. Returns how many bytes were uploaded.
    ///
    /// @return usage if the streamer's cache is larger than the pool, or chunks were added
    core::Result<std::uint64_t> apply(const voxels::ChunkFrame& frame);
    /// What has become known since the last call of which chunks can be seen in streamed frames,
    /// oldest first. Doesn't wait: after `finish`, all frames are known.
    core::Result<std::vector<FrameSight>> takeSights();
    /// The number of the last streamed frame that the device has completed; 0 if there is none.
    /// Doesn't wait.
    core::Result<std::uint64_t> completedFrame();

    /// Draws a picture of the view's size, and returns before it is done.
    ///
    /// Voxels and meshes hide each other. As meshes they get their light by their normals; a colour
    /// takes the place of the look's materials. They receive the sun's shadows and cast some, into
    /// the same map.
    ///
    /// @return usage if the view is not valid or too large for the device, or a chunk that is to be
    ///         drawn isn't there, or there are draws of both kinds
    core::Result<FrameStats>
    draw(const hierarchy::View& view, const Scene& scene, const VoxelScene& voxels = {});
    /// What of a scene may cast shadows into a picture of it; nothing if it has none.
    [[nodiscard]] std::optional<Sunlight>
    sunlight(const hierarchy::View& view, const Scene& scene) const;
    /// Waits for the last picture. @return what its passes cost on the GPU, in order
    core::Result<std::vector<PassTime>> finish();

    /// Waits for the last picture and copies it. Usage if nothing was drawn yet.
    core::Result<core::Image> readImage();
    /// Waits for the last picture and copies its depth, rows from the top: near plane / distance
    /// along the view direction; 0 where there is nothing. Of several samples, the first.
    core::Result<std::vector<float>> readDepth();
    /// Waits for the last picture. @return which voxel each pixel shows, rows from the top. Of
    ///         several samples, the first.
    core::Result<std::vector<ShownVoxel>> readVoxels();
    /// Waits for the last picture. @return which of its chunks can be seen: of those that were
    /// shown, whether any pixel shows them; of those that were tested, whether their box isn't
    /// hidden. Those outside the view pyramid are not listed.
    core::Result<std::vector<ChunkSight>> readSight();
    /// Waits for the last picture. @return its pattern node; none if it wasn't asked for
    ///         (VoxelScene::findsPattern), or no voxel is seen
    core::Result<std::optional<ShownPattern>> readPattern();
    [[nodiscard]] const hierarchy::Domain& domain() const;
    [[nodiscard]] const RendererOptions& options() const;
    /// The near plane of a scene that doesn't name one [world].
    [[nodiscard]] double defaultNearPlane() const;

private:
    struct Parts;
    explicit Renderer(std::unique_ptr<Parts> parts);

    std::unique_ptr<Parts> _parts;
};

} // namespace isofront::render
