#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>

#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace isofront::voxels {

// Which level of detail an object, or a chunk, is shown at: a number that changes without jumps, 0
// the finest.
//
// Source: S. Jablonski and T. Martyn, "Real-time rendering of continuous levels of detail for
// sparse voxel octrees", sections 4 to 6. Differs: their levels count the other way round, so that
// their N - LOD is our level.

/// The level by distance: one coarser every `offset`; equation 2.
/// @param distance  from the eye, at least 0 [world]
/// @param offset    more than 0 [world]
/// @param coarsest  level
/// @return 0 to `coarsest`
double levelAtDistance(double distance, double offset, std::uint32_t coarsest);

/// How the pixels that a pattern node fills decide on the level. A pattern node is the voxel that
/// fills the most, as far as known.
struct FillRates {
    double most = 16;       ///< of the finest level, for it to show all that it has [px]
    double least = 1;       ///< of fewer, a coarser level will do [px]
    double progression = 1; ///< how `most` grows from level to level: 1 adds, more multiplies

    /// `usage` unless all are finite, positive, and `most` at least six times `least`: next to each
    /// other, levels differ fourfold, and would alternate.
    [[nodiscard]] std::optional<core::Error> check() const;
    /// The pixels from which on a level is too coarse: `most` times the sum of `progression`^i for
    /// i from 0 to `level`. Equation 4. Differs: there the sum is printed without the power.
    [[nodiscard]] double threshold(std::uint32_t level) const;
    /// How far a level is on the way to the next finer one, 0 to 1; equation 4.
    [[nodiscard]] double weight(double fill, std::uint32_t level) const;
};

enum class LevelStep { coarser, stay, finer };
/// Equation 5. Differs: there the weight, not the fill, is compared with the least.
LevelStep stepOf(const FillRates& rates, double fill, std::uint32_t level);

/// A pattern node known roughly: a voxel in the middle of the object, there or not.
/// @param edge           of a voxel [world]
/// @param pixelsPerUnit  pixels that a length of 1 covers at distance 1
/// @return the pixels that it covers at the centre of the image: the area of its outline as seen
/// from far away. From within its own size, that at this distance.
double
approximateFill(const core::Box& bounds, double edge, const glm::dvec3& eye, double pixelsPerUnit);

/// A pattern node known by a picture: the voxel nearest to the eye.
struct PatternNode {
    std::uint32_t id = 0;
    std::uint32_t depth = 0;
    std::uint64_t pixels = 0; ///< that show it

    friend bool operator==(const PatternNode&, const PatternNode&) = default;
};
inline constexpr std::uint64_t kNoPatternPixel = 0xffffffffffffffffU;
/// @param picture  of each pixel, the depth in the upper half, nearer is less, and the voxel's id
///                 in the lower one; kNoPatternPixel where nothing is
/// @return of equally near voxels the one with the lowest id; none in an empty picture
std::optional<PatternNode> patternNode(std::span<const std::uint64_t> picture);
/// The pixels that a pattern node counts for: those that show it, or, where other voxels hide part
/// of it, those that it would cover.
/// @param approximate  as if all of it were seen [px]
double fillOf(const PatternNode& node, double approximate);

/// The level to begin with: of those that fill at least `least` pixels, the one that fills the
/// fewest; equal ones, the finer.
/// @param fills  of the pattern node of each level, the finest first
/// @return the coarsest if none fills as much
std::uint32_t calibratedLevel(std::span<const double> fills, double least);

/// What a frame showed of an object.
struct LevelObservation {
    double fill = 0;         ///< of a pattern node [px]; 0 if none was on screen
    std::uint32_t level = 0; ///< of that node
    /// The object's. If both are known, and there are no more pixels than voxels, nothing finer is
    /// shown.
    std::uint64_t pixels = 0;
    std::uint64_t voxels = 0; ///< that were drawn
};

/// A level on its way to the next finer one.
struct ShownLevel {
    std::uint32_t level = 0;
    double weight = 0; ///< 0: itself; below 1

    /// 0 the finest
    [[nodiscard]] double number() const { return static_cast<double>(level) - weight; }
    friend bool operator==(const ShownLevel&, const ShownLevel&) = default;
};

struct LevelControlSettings {
    FillRates rates{};
    std::uint32_t framesToAgree = 2;  ///< in a row, before another level is taken; at least 1
    std::uint32_t framesOfLevel = 16; ///< that showing another level takes at least; at least 1
    std::uint64_t fewestPixels = 1;   ///< objects of no more are left alone
};

/// Follows what frames show of an object, and says how to show it in the next.
///
/// The number shown changes by at most a level in `framesOfLevel` frames. If eye and object rest,
/// it comes to rest. Detail comes and goes at the same speed.
///
/// Differs: in the source, the weight jumps when the level changes, because the next level's
/// pattern node fills a fourth. Here the weight of a level counts from that fourth on.
///
/// Thread: one at a time.
class LevelControl {
public:
    /// @param start  level, see calibratedLevel
    /// @return `usage` for settings that make no sense
    static core::Result<LevelControl>
    create(const LevelControlSettings& settings, std::uint32_t coarsest, std::uint32_t start);

    /// Takes what the last frame showed.
    ShownLevel update(const LevelObservation& observation);
    [[nodiscard]] ShownLevel shown() const;

private:
    LevelControl(const LevelControlSettings& settings, std::uint32_t coarsest, std::uint32_t start);
    [[nodiscard]] double weightOf(double fill) const;

    LevelControlSettings _settings;
    std::uint32_t _coarsest;
    std::uint32_t _level; ///< decided on
    double _number;       ///< shown
    LevelStep _wish = LevelStep::stay;
    std::uint32_t _wished = 0; ///< frames in a row
};

} // namespace isofront::voxels
