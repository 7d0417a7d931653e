#include "ChunkSelection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <map>
#include <set>
#include <vector>

namespace isofront::voxels {
namespace {

using Keys = std::set<ChunkKey>;

constexpr ChunkKey kRoot{2, 0, 0, 0};
constexpr ChunkKey kLeft{1, 0, 0, 0};
constexpr ChunkKey kRight{1, 1, 0, 0};

/// Four chunks in a row, above them two, above them one; a frame's visibility is whatever a test
/// says, and comes when a test says so.
class Script {
public:
    explicit Script(StreamingSettings settings = {})
        : tree(*ChunkTree::create(lattice(), entries())), selection(tree, [&] {
              settings.voxelPixels = 1e-6;
              settings.hiddenFrames = std::max(1U, settings.hiddenFrames);
              return settings;
          }())
    {
        view.eye = {-1, 0.5, 0.5};
    }

    /// Begins a frame, tells what frames before have shown, and draws.
    Keys next(const std::vector<std::uint64_t>& known = {})
    {
        ++frame;
        selection.begin(view);
        for (const std::uint64_t number : known)
            selection.learn({number, visible[number]});
        selection.draws(
            frame, 1, [](ChunkIndex) { return true; }, draws);
        for (const ChunkDraw& draw : draws)
            visible[frame].push_back(seen.contains(draw.key) ? 1 : 0);
        return only(false);
    }
    Keys only(bool tested) const
    {
        Keys keys;
        for (const ChunkDraw& draw : draws)
            if (draw.occlusionOnly == tested)
                keys.insert(draw.key);
        return keys;
    }
    /// The second pass of this frame.
    std::vector<ChunkDraw> again()
    {
        std::vector<ChunkDraw> second;
        selection.secondPass(
            visible[frame], [](ChunkIndex) { return true; }, second);
        for (const ChunkDraw& draw : second)
            visible[frame].push_back(seen.contains(draw.key) ? 1 : 0);
        return second;
    }

    static ChunkKey leaf(std::uint32_t x) { return {0, x, 0, 0}; }
    static Keys leaves(std::uint32_t first, std::uint32_t last)
    {
        Keys keys;
        for (std::uint32_t x = first; x <= last; ++x)
            keys.insert(leaf(x));
        return keys;
    }

    ChunkTree tree;
    ChunkSelection selection;
    ChunkView view;
    std::uint64_t frame = 0;
    Keys seen; ///< what frames show from now on, if it is drawn or tested
    std::map<std::uint64_t, std::vector<std::uint32_t>> visible;
    std::vector<ChunkDraw> draws;

private:
    static VoxelLattice lattice()
    {
        VoxelLattice lattice;
        lattice.edge = 1.0 / kChunkEdge;
        lattice.levels = 3;
        lattice.resolution = 4 * kChunkEdge;
        return lattice;
    }
    static std::vector<ChunkEntry> entries()
    {
        std::vector<ChunkEntry> entries;
        for (std::uint32_t level = 0; level < 3; ++level)
            for (std::uint32_t x = 0; x < 4U >> level; ++x) {
                ChunkEntry entry;
                entry.key = {level, x, 0, 0};
                entry.voxels = entry.parents = 1;
                entries.push_back(entry);
            }
        return entries;
    }
};

StreamingSettings hiddenFor(unsigned frames)
{
    StreamingSettings settings;
    settings.hiddenFrames = frames;
    return settings;
}

TEST(ChunkSelection, closesALevelAFrame)
{
    Script script(hiddenFor(1));
    EXPECT_EQ(script.next(), Script::leaves(0, 3));
    EXPECT_EQ(script.next({1}), Script::leaves(0, 3)) << "what comes into view counts as seen";
    EXPECT_EQ(script.next({2}), Keys());
    EXPECT_EQ(script.only(true), (Keys{kLeft, kRight}));
    EXPECT_EQ(script.next({3}), Keys());
    EXPECT_EQ(script.only(true), Keys{kRoot});
    EXPECT_EQ(script.next({4}), Keys());
    EXPECT_EQ(script.only(true), Keys{kRoot});
}

TEST(ChunkSelection, waitsForAsManyHiddenFramesAsSet)
{
    for (unsigned frames = 1; frames < 6; ++frames) {
        Script script(hiddenFor(frames));
        std::uint64_t closed = 0;
        script.next();
        for (std::uint64_t i = 1; closed == 0; ++i) {
            ASSERT_LT(i, 20U);
            if (script.next({i}).empty())
                closed = script.frame;
        }
        // visible in the first one, as far as one knows
        EXPECT_EQ(closed, 2U + frames);
    }
}

TEST(ChunkSelection, closesOnlyWhereAllIsHidden)
{
    Script script(hiddenFor(1));
    script.seen = {Script::leaf(2)};
    script.next();
    for (std::uint64_t i = 1; i < 10; ++i)
        script.next({i});
    EXPECT_EQ(script.only(false), Script::leaves(2, 3));
    EXPECT_EQ(script.only(true), Keys{kLeft});
}

TEST(ChunkSelection, opensWhatLaterTurnsOutToHaveBeenSeen)
{
    // a frame shows something in a place that was closed meanwhile, for what was known before
    Script script(hiddenFor(1));
    script.next();
    script.next();
    script.seen = {Script::leaf(1)};
    script.next();
    script.seen = {};
    EXPECT_EQ(script.next({1, 2}), Keys());
    EXPECT_EQ(script.only(true), (Keys{kLeft, kRight}));
    EXPECT_EQ(script.next({3}), Script::leaves(0, 1));
    EXPECT_EQ(script.only(true), Keys{kRight});
}

TEST(ChunkSelection, drawsAllInTheSecondPass)
{
    // the root has just been closed, and what is below it was closed before
    Script script(hiddenFor(1));
    script.next();
    script.next({1});
    script.next({2});
    script.seen = {kRoot};
    EXPECT_EQ(script.next({3}), Keys());
    ASSERT_EQ(script.only(true), Keys{kRoot});
    const std::vector<ChunkDraw> second = script.again();
    ASSERT_EQ(second.size(), 4U);
    for (const ChunkDraw& draw : second) {
        EXPECT_FALSE(draw.occlusionOnly);
        EXPECT_EQ(draw.key.level, 0U);
    }
    // and it stays open
    EXPECT_EQ(script.next({4}), Script::leaves(0, 3));
}

TEST(ChunkSelection, opensWhatPassesItsTestUntilTheViewChanges)
{
    Script script(hiddenFor(1));
    script.next();
    script.next({1});
    script.next({2});
    script.seen = {kLeft}; // larger than what it stands for, which is hidden
    script.next({3});
    EXPECT_EQ(script.only(true), Keys{kRoot}) << "not known yet";
    script.seen = {kRoot, kLeft};
    for (std::uint64_t i = 4; i < 40; ++i)
        script.next({i});
    EXPECT_EQ(script.only(false), Script::leaves(0, 1));
    EXPECT_EQ(script.only(true), Keys{kRight});
    const std::uint64_t before = script.frame;
    std::uint64_t closed = 0;
    for (std::uint64_t i = before; i < before + 20 && closed == 0; ++i) {
        script.view.eye.x -= 1e-3;
        if (script.next({i}).empty())
            closed = i;
    }
    EXPECT_GT(closed, 0U) << "closed once the view has changed";
    EXPECT_TRUE(script.only(true).contains(kLeft));
}

TEST(ChunkSelection, keepsOpenForSomeFramesEvenIfTheViewChanges)
{
    Script script(hiddenFor(1));
    script.next();
    script.next({1});
    script.next({2});
    std::uint64_t opened = 0;
    std::uint64_t alternations = 0;
    script.seen = {kRoot, kLeft};
    bool wasOpen = false;
    for (std::uint64_t i = 3; i < 40; ++i) {
        script.view.eye.x -= 1e-3;
        const bool isOpen = script.next({i}).contains(Script::leaf(0));
        opened += isOpen ? 1 : 0;
        alternations += isOpen != wasOpen ? 1 : 0;
        wasOpen = isOpen;
    }
    EXPECT_GT(opened, 24U);
    EXPECT_LE(alternations, 10U);
}

TEST(ChunkSelection, drawsWhatWasOutOfViewInBetween)
{
    Script script(hiddenFor(1));
    script.seen = {Script::leaf(0)};
    script.next();
    script.next({1});
    script.next({2});
    ASSERT_EQ(script.only(true), Keys{kRight});
    const ChunkView all = script.view;
    script.view.planes[0] = {{-1, 0, 0}, 2.5}; // x <= 1.5: only what is left
    script.next({3});
    script.next({4});
    script.view = all;
    script.selection.begin(script.view);
    std::vector<ChunkSelection::Wanted> wanted;
    script.selection.wanted(1, wanted);
    EXPECT_EQ(wanted.size(), script.tree.size()) << "and needs it";
    script.selection.draws(
        ++script.frame, 1, [](ChunkIndex) { return true; }, script.draws);
    EXPECT_EQ(script.only(false), Script::leaves(0, 3));
}

TEST(ChunkSelection, doesNotCloseAroundWhatComesIntoView)
{
    Script script(hiddenFor(1));
    script.seen = {Script::leaf(0)};
    const ChunkView all = script.view;
    script.view.planes[0] = {{-1, 0, 0}, 1.5}; // x <= 0.5: only the first
    script.next();
    script.next();
    script.seen = {};
    EXPECT_EQ(script.next({1, 2}), Script::leaves(0, 0));
    script.view = all;
    EXPECT_EQ(script.next({3}), Script::leaves(0, 3));
}

TEST(ChunkSelection, doesNotCloseForWhatWasDrawnOtherwise)
{
    Script script(hiddenFor(1));
    script.seen = {Script::leaf(0)};
    script.next();
    script.next({1});
    script.next({2});
    script.next({3});
    ASSERT_EQ(script.only(true), Keys{kRight});
    // all is hidden now, in frame 5
    script.seen = {};
    script.next({4});
    // but from 6 on two are drawn whole, of whose larger voxels nothing is known
    script.view.pixelsPerUnit = 1e-4;
    ASSERT_EQ(script.next(), (Keys{kLeft, kRight}));
    EXPECT_EQ(script.next({5}), (Keys{kLeft, kRight}));
    EXPECT_EQ(script.next({6}), Keys());
    EXPECT_EQ(script.only(true), Keys{kRoot});
}

TEST(ChunkSelection, ignoresVisibilityOfOtherFrames)
{
    Script script(hiddenFor(1));
    script.next();
    script.next();
    script.selection.begin(script.view);
    const std::vector<std::uint32_t> none(4, 0);
    script.selection.learn({77, none});
    script.selection.learn({1, std::span(none).first(3)});
    script.selection.draws(
        3, 1, [](ChunkIndex) { return true; }, script.draws);
    EXPECT_EQ(script.only(false), Script::leaves(0, 3));
}

} // namespace
} // namespace isofront::voxels
