#pragma once

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkForm.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/ChunkTree.h>
#include <isofront/voxels/ChunkView.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace isofront::voxels {

/// What is shown where not all children of a chunk have come yet.
enum class StreamingPolicy {
    /// The parent, until all children in view are there: the model is closed in every picture.
    closed,
    /// The children that are there: holes for a moment, but no step back in detail.
    partial,
};

/// Chunks start at multiples of it [bytes].
inline constexpr std::uint64_t kChunkAlignment = 256;

struct StreamingSettings {
    /// A chunk is refined while its nearest voxels cover more than this [px], > 0. Less is more
    /// accurate and costs voxels with its inverse square.
    double voxelPixels = 1;
    /// Voxels of the finest level that cover more than this are reported as too coarse [px].
    double sourcePixels = 1;
    StreamingPolicy policy = StreamingPolicy::closed;
    /// Whether what is hidden is found out and drawn coarsely. Needs `Visibility`.
    bool occlusion = true;
    /// Whether levels of detail change into each other without a jump, by ChunkDraw::weight. What
    /// that takes of a chunk (TransitionNodes) is loaded with it and lies behind it. It costs: of a
    /// surface, 2.7 times the memory of chunks without colours, and 2.8 times the nodes to draw.
    bool continuous = false;
    /// A chunk counts as hidden after so many frames without a pixel; at least one.
    unsigned hiddenFrames = 2;
    /// Memory of the device for chunks [bytes]. If what a view needs doesn't fit, all detail
    /// becomes coarser until it does.
    std::uint64_t cacheBytes = std::uint64_t{1} << 30U;
    /// At most so much is uploaded for a frame, a chunk in parts if need be [bytes], >= 256.
    std::uint64_t uploadBytes = std::uint64_t{8} << 20U;
    /// At most so much is moved within the cache for a frame, or one chunk [bytes].
    std::uint64_t moveBytes = std::uint64_t{32} << 20U;
    /// Chunks that are loaded or being loaded, but not uploaded: at most so much, or one [bytes].
    std::uint64_t hostBytes = std::uint64_t{64} << 20U;
    ChunkForm form = standardForm();
};

/// What a frame is in a transition, which is what lets chunks change over several frames: a clock
/// says when one begins and how far it has come. As long as it lasts, the frames' draws make two
/// pictures: the former one, that was there when it began, and the present one, that was chosen
/// then. Each of them is closed. In between nothing is chosen anew but for what comes into view.
struct ChunkTurn {
    bool begins = true; ///< a transition begins with this frame
    /// Of the present picture. A transition that begins with 1 has no former one: so the default is
    /// that every frame shows what is best at once.
    float weight = 1;
    /// Where something else is shown in place of voxels, in both pictures; empty for nowhere. A
    /// chunk that is covered as a whole isn't drawn but listed, counts as visible, and its siblings
    /// don't wait for it. Must be true of all parts of what it is true of.
    std::function<bool(const ChunkTree::Node&)> isCovered = {};
    /// Of what is covered: whether it isn't even to be loaded, as it will stay so for a while.
    std::function<bool(const ChunkTree::Node&)> isUnneeded = {};
};

/// A chunk that isn't drawn because something else covers its place.
struct CoveredChunk {
    ChunkIndex index = 0;
    std::uint32_t level = 0; ///< of the voxels that would be drawn there: its own, or an ancestor's
};

/// One chunk to be drawn.
struct ChunkDraw {
    ChunkKey key;             ///< whose voxels these are
    ChunkIndex index = 0;     ///< in the tree
    std::uint32_t voxels = 0; ///< how many
    /// Null, but for a chunk that can't be read. Then what is drawn in its place is a part of a
    /// coarser chunk, `key`, with fewer voxels than that has: this says what lies there. Valid
    /// until the next update.
    const ChunkEntry* standIn = nullptr;
    std::uint64_t offset = 0; ///< where it lies in the cache [bytes]
    double distance = 0;      ///< from the eye to the nearest point of its box [world]
    double voxelPixels = 0;   ///< what an edge of its nearest voxel covers there [px]
    /// How far its look has come from its parent's to its own, 0 to 1: a function of the view
    /// alone, for continuous level of detail.
    float weight = 1;
    /// Whether it is to be drawn so: with settings that say so, a weight below 1, and a transition
    /// and a parent that both lie in the cache. If not, it looks like itself.
    bool fades = false;
    std::uint64_t transitionOffset = 0; ///< where its transition lies: parents, then nodes [bytes]
    std::uint64_t parentOffset = 0;     ///< where its parent lies [bytes]
    /// Only tests whether anything of it would be visible: after all that is opaque, all faces of
    /// all voxels, passing at equal depth, writing neither colour nor depth. Voxels contain all
    /// that they stand for, so what is behind is then known to be hidden.
    bool occlusionOnly = false;
    /// Which of the two pictures of a transition it is part of.
    bool inFormer = true;
    bool inPresent = true;
    /// The part that is drawn, one bit for each octant in the order of ChunkKey::child; less than
    /// all only of what casts shadows.
    std::uint8_t octants = 0xff;
    /// No voxels are fine enough here: the model's source should be drawn, if there is one.
    bool needsSource = false;
};

/// Bytes to be copied into the cache.
struct ChunkUpload {
    ChunkIndex index = 0;
    std::uint64_t offset = 0;        ///< in the cache [bytes]
    std::span<const std::byte> data; ///< valid until the next update
    bool isLast = true;              ///< with it the chunk is complete
};

/// A chunk to be copied within the cache; the ranges don't overlap.
struct ChunkMove {
    ChunkIndex index = 0;
    std::uint64_t from = 0; ///< [bytes]
    std::uint64_t to = 0;   ///< [bytes]
    std::uint64_t bytes = 0;
};

/// What a frame has to do, in this order: moves, uploads, draws.
///
/// No upload and no move writes where a frame that isn't complete may read, or reads what is
/// written for the same frame.
struct ChunkFrame {
    std::vector<ChunkMove> moves;
    std::vector<ChunkUpload> uploads;
    /// Opaque ones first, front to back; then those that only test, front to back.
    std::vector<ChunkDraw> draws;
    std::size_t opaque = 0;            ///< how many of the draws are
    std::size_t fading = 0;            ///< how many of the draws are part of one picture only
    std::vector<CoveredChunk> covered; ///< what would be drawn, too, by ChunkTurn::isCovered

    /// Chunks that have left the cache since the last frame.
    std::vector<ChunkIndex> evictions;
    /// Chunks that can't be read, found since the last frame: each is named once. From now on the
    /// nearest chunk above that can be read is shown in their place, and nowhere else.
    std::vector<core::Error> damaged;

    std::uint64_t uploadBytes = 0;   ///< of this frame's uploads
    std::uint64_t residentBytes = 0; ///< of the chunks in the cache
    std::uint64_t wantedBytes = 0;   ///< of the chunks that this view needs
    std::size_t missing = 0;         ///< chunks that it needs and that aren't there
    /// Times as many pixels a voxel as asked for, for want of room; 1 if there is enough.
    double coarsening = 1;
    /// Nothing is missing, moves, fades, or waits for a transition: with the same view the next
    /// frame differs from this one only by what becomes known of visibility.
    bool isComplete = false;
    bool isRefused = false; ///< the view was not valid; the one before was taken
};

/// What a frame's draws have shown.
struct Visibility {
    std::uint64_t frame = 0;
    /// One for each of the frame's draws, in their order, then for those of its second pass: not 0
    /// if a fragment has passed the depth test. Tests before shading (early fragment tests), or
    /// what is hidden counts too.
    std::span<const std::uint32_t> visible;
};

/// Chooses the chunks of a model that a view needs, brings them from their store and gives them
/// places in the device's memory. Knows of no device: each update says what to copy and draw.
///
/// What a view needs depends on the view, on what is known to be hidden, and on the size of the
/// cache; never on what happens to be loaded. So it is loaded once, and nothing is thrown out that
/// is needed, even if the cache is too small for all detail.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 4. Differs: what is not visible leaves the cache oldest first, not all at once; a hidden
/// chunk that looks visible when coarse is kept open, or it would be tried again and again; where
/// the cache is too small, detail is reduced evenly.
///
/// Thread: one at a time. Loading runs in `jobs`.
class ChunkStreamer {
public:
    /// Fails with `badData` for a store whose directory makes no tree, and `resourceLimit` if the
    /// cache can't hold the coarsest chunk.
    /// @param jobs  shared; not null
    static core::Result<std::unique_ptr<ChunkStreamer>> create(
        std::shared_ptr<const ChunkStore> store,
        const StreamingSettings& settings,
        std::shared_ptr<core::Jobs> jobs);

    ChunkStreamer() = default;
    ChunkStreamer(const ChunkStreamer&) = delete;
    ChunkStreamer& operator=(const ChunkStreamer&) = delete;
    /// Waits for chunks that are just being read.
    virtual ~ChunkStreamer() = default;

    /// The next frame. Never waits for the store, unless jobs run at once.
    /// @param frame      its number, greater than the last one's and than 0
    /// @param completed  frames up to this one are done on the device
    /// @param seen       what frames before have shown, if it has become known since the last
    ///                   update, oldest first. Frames may be left out.
    /// @param turn       what the frame is in a transition. What only a former picture needs stays
    ///                   in the cache if there is room; if not, coarser chunks take its place.
    /// @return valid until the next update
    virtual const ChunkFrame& update(
        const ChunkView& view,
        std::uint64_t frame,
        std::uint64_t completed,
        std::span<const Visibility> seen = {},
        const ChunkTurn& turn = {}) = 0;

    /// What must be drawn besides, in the same frame, once its draws are known to have shown this:
    /// whatever lies behind those that only test and have passed. With it the picture is exactly
    /// that of all chunks. Not called: it comes in a later frame.
    /// @param visible  one for each draw of the last update
    /// @return opaque, front to back; valid until the next update
    virtual std::span<const ChunkDraw> secondPass(std::span<const std::uint32_t> visible) = 0;

    /// What casts shadows into the same frame, out of what is there: all of the model that the
    /// sun's map covers, in view or not. Nothing is loaded for it. Out of view, and where the map
    /// is coarse, it is coarser than what is drawn; but it contains all that it stands for.
    /// @param sun    what the map covers; valid
    /// @param texel  width of its texels: voxels needn't be finer [world]
    /// @return in any order; valid until the next update
    virtual std::span<const ChunkDraw> casters(const ChunkView& sun, double texel) = 0;

    /// Waits until a chunk that was asked for is loaded, if there is any, so that the next update
    /// gets further: for pictures that are to be complete.
    virtual void waitForChunks() = 0;

    [[nodiscard]] virtual const ChunkTree& tree() const = 0;
    [[nodiscard]] virtual const StreamingSettings& settings() const = 0;
};

} // namespace isofront::voxels
