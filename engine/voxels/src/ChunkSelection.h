#pragma once

#include <isofront/voxels/ChunkStreamer.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace isofront::voxels {

/// Decides which chunks of a tree a view needs, and which of those that are there are drawn.
///
/// A frame is: `begin`; `learn` what earlier frames have shown; `wanted`, as often as one likes;
/// `draws`; perhaps `secondPass`.
///
/// A chunk that needs refinement is in one of two states. Open: its children stand for it. Closed:
/// all of them were hidden for some frames, so it only tests, as a whole, whether that is still
/// so. A closed chunk counts as hidden for its parent, so that closing climbs one level a frame.
/// A closed chunk that passes is opened. If its children turn out to be hidden nonetheless, which
/// voxels that are larger than they make possible, it stays open until the view changes.
///
/// Source: M. Chajdas, M. Reitinger and R. Westermann, "Scalable rendering for very large meshes",
/// section 4, figures 7 to 9.
///
/// In a transition it decides twice: a chunk's children may stand for it in one picture, and it for
/// itself in the other. Below it a chunk counts for the pictures by which it is reached. Decisions
/// are made when a transition begins, the former picture's being those of the present one before,
/// and kept until the next; but alike for both where a chunk comes into view or is opened. Where
/// children are gone that a decision needs, their parent takes their place, and keeps it.
///
/// Thread: one at a time.
class ChunkSelection {
public:
    /// Whether a chunk is in the device's memory.
    using IsThere = std::function<bool(ChunkIndex)>;

    /// @param tree  outlives the selection
    ChunkSelection(const ChunkTree& tree, const StreamingSettings& settings);

    /// @param view  valid
    void begin(const ChunkView& view, const ChunkTurn& turn = {});
    /// What an earlier frame has shown. Frames that are unknown, or shown otherwise, say nothing.
    void learn(const Visibility& seen);

    struct Wanted {
        ChunkIndex index = 0;
        double distance = 0; ///< [world]
    };
    /// All that the view needs, parents included, coarsest level first, then nearest first.
    /// @param coarsening  times as many pixels a voxel as set, at least 1
    void wanted(double coarsening, std::vector<Wanted>& chunks) const;

    /// What the last frame's cuts were made of, and this frame's still need, parents first. They
    /// are there; what of them isn't wanted should stay if it can.
    void kept(std::vector<ChunkIndex>& chunks) const;
    /// What else the last draws would have had, by ChunkTurn::isCovered.
    [[nodiscard]] const std::vector<CoveredChunk>& covered() const { return _covered; }
    /// Whether the last draws fade, or wait to be chosen anew.
    [[nodiscard]] bool isChanging() const { return _isChanging; }

    /// What is drawn of what is there, in the order of ChunkFrame::draws.
    /// @param frame  its number
    /// @return how many of the draws are opaque
    std::size_t draws(
        std::uint64_t frame,
        double coarsening,
        const IsThere& isThere,
        std::vector<ChunkDraw>& draws);
    /// As ChunkStreamer::secondPass: fills `draws` with what comes in addition.
    void secondPass(
        std::span<const std::uint32_t> visible,
        const IsThere& isThere,
        std::vector<ChunkDraw>& draws);

    /// From now on a part of a coarser chunk, `standIn`, is what is there of a chunk that can't be
    /// read; null if there is none, as for the root, so that its children have to do without it.
    void markDamaged(ChunkIndex index, const ChunkEntry* standIn);
    /// From now on the chunk is itself again.
    void markSound(ChunkIndex index) { _damaged.erase(index); }
    [[nodiscard]] bool isDamaged(ChunkIndex index) const { return _damaged.contains(index); }
    /// Whether there isn't anything to draw for a chunk.
    [[nodiscard]] bool isForced(ChunkIndex index) const;

private:
    /// Counts the frames from 2 on; 0 is never, and not the frame before the first either.
    using Tick = std::uint64_t;
    /// Bits.
    using Pictures = unsigned;
    static constexpr Pictures kFormer = 1;
    static constexpr Pictures kPresent = 2;
    static constexpr Pictures kBoth = 3;

    struct Node {
        Tick visited = 0;  ///< last time that it was in view, and its parent open
        Tick seen = 0;     ///< last time that it was visible, or may have been
        Tick open = 0;     ///< last time that all children in view stood for it
        Tick drawn = 0;    ///< last time that it was drawn or tested as a whole ...
        Tick since = 0;    ///< ... and since when without a break
        Tick keptOpen = 0; ///< not to be closed before
        std::uint64_t keptOpenView = 0;
        Pictures reached = 0;   ///< when last visited, the pictures that it was part of ...
        Pictures expanded = 0;  ///< ... and those in which its children stand for it,
        bool isDecided = false; ///< if that has been decided
        bool isClosed = false;
        bool wasTested = false; ///< when it was last drawn as a whole, it was only tested
    };
    struct Damaged {
        std::optional<ChunkEntry> standIn;
        core::Box box; ///< of the chunk, of all below it, and of the stand-in [world]
    };
    /// What was drawn in a frame whose visibility isn't known yet.
    struct Record {
        std::uint64_t frame = 0;
        Tick tick = 0;
        std::vector<ChunkIndex> chunks;
        std::size_t firstTested = 0; ///< of the first pass
        std::size_t lastTested = 0;  ///< past them; what follows is of the second pass
    };

    /// Of what is drawn for it [world].
    [[nodiscard]] const core::Box& boxOf(ChunkIndex index) const;
    [[nodiscard]] bool mayShow(ChunkIndex index) const { return _view.mayShow(boxOf(index)); }
    [[nodiscard]] double distanceTo(ChunkIndex index) const
    {
        return _view.distanceTo(boxOf(index));
    }
    [[nodiscard]] double pixelsOf(ChunkIndex index, double distance) const;
    [[nodiscard]] bool needsRefinement(ChunkIndex index, double pixels, double coarsening) const;
    [[nodiscard]] bool isClosed(ChunkIndex index) const;
    [[nodiscard]] bool isCovered(ChunkIndex index) const;
    Tick visit(
        ChunkIndex index, Pictures pictures, const IsThere& isThere, std::vector<ChunkDraw>& draws);
    struct Children {
        std::array<ChunkIndex, 8> ready{}; ///< those in view that are there
        std::size_t count = 0;
        bool areAll = false;     ///< in view
        bool mayStandIn = false; ///< for their parent
    };
    [[nodiscard]] Children childrenInView(ChunkIndex index, const IsThere& isThere) const;
    /// Lists the children of a chunk that they all would have to wait for, were they not covered.
    void listMissing(ChunkIndex index, Pictures pictures, const IsThere& isThere);
    [[nodiscard]] Pictures decided(Pictures before, Pictures best, bool isPossible) const;
    void enter(ChunkIndex index);
    void draw(
        ChunkIndex index,
        double distance,
        double pixels,
        bool isTest,
        Pictures pictures,
        std::vector<ChunkDraw>& draws);
    void markSeen(ChunkIndex index, Tick tick);
    void open(ChunkIndex index);
    void closeHidden(const Record& record);

    const ChunkTree& _tree;
    StreamingSettings _settings;
    std::vector<Node> _nodes;
    std::map<ChunkIndex, Damaged> _damaged;
    ChunkView _view;
    std::uint64_t _viewVersion = 0; ///< counts the changes of the view, from 1 on
    Tick _tick = 1;
    double _coarsening = 1;
    ChunkTurn _turn;
    std::vector<ChunkIndex> _visited; ///< in the last frame, parents first
    std::vector<CoveredChunk> _covered;
    bool _isChanging = false;
    bool _isSecondPass = false;  ///< in which nothing is only tested
    std::deque<Record> _records; ///< oldest first
};

} // namespace isofront::voxels
