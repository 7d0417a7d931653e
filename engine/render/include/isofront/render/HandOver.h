#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>
#include <isofront/surface/Delta.h>
#include <isofront/voxels/Chunk.h>
#include <isofront/voxels/ChunkTree.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace isofront::render {

/// How far surface voxels look off the mesh of the same field, across the surface, as a share of
/// their edge (root of the mean square). Their outlines are off by up to a whole edge. Measured:
/// see docs/measurements.md.
inline constexpr double kVoxelError = 0.75;

struct HandOverSettings {
    /// How far voxels may be off the mesh in the picture where they take its place [px], > 0. Less:
    /// meshes reach further, and cost triangles with the square of that.
    double pixels = 0.6;
    /// The error that the surface was asked for [px], > 0: a mesh that is as good as that has what
    /// it needs, and voxels don't take its place for being a little better.
    double meshPixels = 2;
    /// Who has a place keeps it until his error is so many times as large as another would have to
    /// have it, >= 1.
    double hysteresis = 1.15;
};

/// How many times as strongly as its meshes a field is to be filtered for voxels, at least 1
/// (surface's and voxels' `filterStrength`), for both to show the same surface where voxels take
/// the place of meshes. A mesh that is asked for some error has an axis step of many pixels, and
/// all that is finer is filtered out of it; voxels there are of about one pixel. Filtered no more
/// than they have to be they would show far slopes as rougher than near ones: other outlines, other
/// light, and other materials where those go by the slope.
double voxelFilterFactor(const HandOverSettings& settings);

/// Cubes of space, counted along x first, then y, then z. What lies outside counts as part of the
/// nearest one.
struct BlockGrid {
    glm::dvec3 origin{0.0};       ///< low corner of the first [world]
    double edge = 1;              ///< of a block [world]
    std::uint32_t bits = 5;       ///< its edge is 2^bits voxels of level 0
    glm::uvec3 count{1U, 1U, 1U}; ///< at most kMostBlocks along each axis

    static constexpr std::uint32_t kMostBlocks = 64;

    [[nodiscard]] std::size_t size() const { return std::size_t{count.x} * count.y * count.z; }
    [[nodiscard]] std::size_t index(const glm::uvec3& block) const
    {
        return (std::size_t{block.z} * count.y + block.y) * count.x + block.x;
    }
    /// The block of a place [world].
    [[nodiscard]] glm::uvec3 blockAt(const glm::dvec3& place) const;
    /// The place that a block covers [world].
    [[nodiscard]] core::Box boxOf(const glm::uvec3& block) const;
};

/// Of a block: in which of the two pictures of a transition it belongs to the voxels.
inline constexpr std::uint8_t kVoxelsInFormer = 1;
inline constexpr std::uint8_t kVoxelsInPresent = 2;

/// Who some place belongs to, in the former and in the present picture.
struct Owners {
    std::uint8_t voxels = 0; ///< the pictures in which a part of it is the voxels'
    std::uint8_t meshes = 0; ///< and those in which a part is the meshes'
};

/// What there is of a block's source, the triangles that the voxels were made from.
enum class SourceState : std::uint8_t {
    missing, ///< it isn't there, or nobody knows yet
    there,   ///< it can be shown
    nothing, ///< none of it lies in the block
};

/// The domain that a renderer of a voxel model's source has: its grid contains that of the source.
hierarchy::Domain voxelDomain(const voxels::VoxelLattice& lattice);

/// What stands for a part of a voxel model, or would, if nothing else were shown there.
struct VoxelDetail {
    voxels::ChunkKey part;   ///< the place of this chunk
    std::uint32_t level = 0; ///< of the voxels
};

/// Decides where a surface is shown by its meshes, and where by voxels of the same field.
///
/// Space is cut into blocks, and each has one owner in a picture. Voxels get a block where their
/// error on the screen is within the bound; elsewhere meshes have it if they are as good as they
/// were asked to be; and where neither is so, as after a jump, whoever is less wrong. Blocks
/// without voxels are treated alike, since a mesh that is too coarse may reach into them.
///
/// Decisions are made when a transition begins: what was the present picture becomes the former
/// one.
///
/// Thread: one at a time.
class HandOver {
public:
    /// @param coarsest  the root's chunk, which tells which blocks have voxels at all; null if the
    ///                  tree is empty
    /// @param domain    of the surface
    /// @param latticeSize  of its cells: extractor::ExtractionSettings
    /// @return usage if the settings are out of range, badData if the chunk isn't the root
    static core::Result<HandOver> create(
        const voxels::ChunkTree& tree,
        const voxels::Chunk* coarsest,
        const hierarchy::Domain& domain,
        int latticeSize,
        const HandOverSettings& settings);

    /// The same where meshes are the source of the voxels, which is exact: it gets a block where
    /// voxels are too coarse, once it is there. Until then voxels have everything.
    static core::Result<HandOver> createForSource(
        const voxels::ChunkTree& tree,
        const voxels::Chunk* coarsest,
        const HandOverSettings& settings);

    /// Follows the surface's meshes: every delta, in order.
    void apply(const surface::Delta& delta);
    /// What of the source is there, for the next decision: as many as there are blocks.
    void setSource(std::span<const SourceState> states);
    /// Forgets all meshes.
    void clearMeshes();

    /// Decides anew; meshes have everything before the first time. A view that is not valid changes
    /// nothing.
    /// @param details  of all parts that are in view; no two overlap. Elsewhere voxels count as
    ///                 being as fine as they need to be.
    /// @return whether any block has another owner than before, or had one
    bool begin(const hierarchy::View& view, std::span<const VoxelDetail> details);
    /// The transition is over: what is present is all there is.
    void end();

    /// From there on voxels are fine enough, if they are loaded [world].
    [[nodiscard]] double distance(const hierarchy::View& view) const;
    /// How far meshes are needed around a viewer [world]: see surface::DetailSettings::reach. A
    /// quarter more than the distance, as a viewer moves before cells are there, and a block.
    /// @param coarsening  times as large as asked for are the voxels: voxels::ChunkFrame
    [[nodiscard]] double reach(const hierarchy::View& view, double coarsening = 1) const;

    [[nodiscard]] const BlockGrid& grid() const { return _grid; }
    /// kVoxelsInFormer and kVoxelsInPresent of each block.
    [[nodiscard]] std::span<const std::uint8_t> blocks() const { return _blocks; }
    [[nodiscard]] const HandOverSettings& settings() const { return _settings; }
    /// Whose the blocks are that a box meets [world]. Cost: constant.
    [[nodiscard]] Owners ownersOf(const core::Box& box) const;
    /// The same of the blocks within four voxels of a chunk's: so far voxels are shown beyond what
    /// is theirs, lest there be a gap.
    /// @param box  of the chunk's voxels [world]
    [[nodiscard]] Owners ownersAround(const core::Box& box, std::uint32_t level) const;
    /// How many blocks with voxels are the meshes' and the voxels' in the present picture.
    [[nodiscard]] std::size_t meshBlocks() const { return _meshBlocks; }
    [[nodiscard]] std::size_t voxelBlocks() const { return _occupied - _meshBlocks; }

private:
    struct Cell {
        core::Box box;    ///< around its mesh [world]
        double error = 0; ///< to expect, or measured [world]
    };
    /// How many blocks are the voxels' in the box from the first one on, for all boxes.
    using Sums = std::vector<std::uint32_t>;

    HandOver() = default;
    void measureMeshes(const hierarchy::View& view);
    /// Of the meshes in a block, as `begin` has measured them [px].
    [[nodiscard]] double meshErrorOf(std::size_t block) const;
    void sum();
    [[nodiscard]] std::uint8_t
    decided(double voxelError, double meshError, std::uint8_t before) const;

    HandOverSettings _settings;
    hierarchy::Domain _domain;
    int _latticeSize = 16;
    double _voxelEdge = 1; ///< of level 0 [world]
    BlockGrid _grid;
    std::vector<bool> _hasVoxels;
    std::size_t _occupied = 0;
    std::size_t _meshBlocks = 0;
    std::unordered_map<surface::CellId, Cell, surface::CellIdHash> _cells;
    std::vector<std::uint8_t> _blocks;
    std::array<Sums, 2> _sums; ///< of the former and of the present picture
    bool _hasSource = false;   ///< meshes are the voxels' source
    std::vector<SourceState> _source;
    // scratch of `begin`
    std::vector<std::uint8_t> _levels; ///< that stand for each block; kAnyLevel if nobody said
    std::vector<float> _meshErrors;    ///< [px]; below 0 where there is no cell
    glm::uvec3 _openLow{0U, 0U, 0U};   ///< around the blocks whose meshes matter
    glm::uvec3 _openHigh{0U, 0U, 0U};  ///< inclusive
};

} // namespace isofront::render
