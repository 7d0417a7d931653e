#include "VoxelFrame.h"

#include "Culling.h"
#include "FrameData.h"
#include "isofront/render/HandOver.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <optional>

namespace isofront::render {

namespace {

/// Farther from the model than so many voxels nothing of it can be seen; and its corners stay
/// within 32 bits.
constexpr double kFarthestEye = 1 << 30;

shared::vec4 row(const glm::dvec3& vector, double last = 0.0)
{
    return shared::vec4(glm::vec3(vector), static_cast<float>(last));
}

glm::dvec3 placeOf(std::uint32_t packed)
{
    return {packed & 0xffU, packed >> 8U & 0xffU, packed >> 16U & 0xffU};
}

/// The view, with lengths in voxels of level 0 and places relative to the eye.
struct LatticeView {
    glm::dvec3 cell{0.0}; ///< that the eye is in
    glm::dvec3 within{0.0};
    Camera camera;
    std::array<glm::dvec3, 4> sides; ///< inward
    double pixels = 1;               ///< of a length of 1 at distance 1
};

LatticeView latticeView(const hierarchy::View& view, const voxels::VoxelLattice& lattice)
{
    LatticeView result;
    const glm::dvec3 eye = (view.eye - lattice.origin) / lattice.edge;
    result.cell = glm::floor(eye);
    result.within = eye - result.cell;
    result.camera = cameraOf(view);
    const Camera& camera = result.camera;
    result.sides = {
        camera.forward * camera.tangentX + camera.right,
        camera.forward * camera.tangentX - camera.right,
        camera.forward * camera.tangentY + camera.up,
        camera.forward * camera.tangentY - camera.up};
    result.pixels = view.pixelsPerUnit();
    return result;
}

bool isWithinReach(const hierarchy::View& view, const voxels::VoxelLattice& lattice)
{
    const glm::dvec3 eye = (view.eye - lattice.origin) / lattice.edge;
    return glm::all(glm::lessThan(glm::abs(eye), glm::dvec3(kFarthestEye)));
}

/// A chunk in the view pyramid.
struct Candidate {
    const PlacedChunk* chunk = nullptr;
    std::uint32_t place = 0; ///< in the list
    double distance = 0;     ///< of its box's nearest point [voxels]
    enum Kind { splat, cubes, fadingCubes, box } kind = cubes;
    std::uint32_t pictures = shared::kInBoth;
    bool isInTransition = false; ///< in one of two pictures only

    /// An order that doesn't depend on how the draws were ordered.
    bool operator<(const Candidate& other) const
    {
        if (kind != other.kind)
            return kind < other.kind;
        if (distance != other.distance)
            return distance < other.distance;
        return chunk->key < other.chunk->key;
    }
};

glm::dvec3 cornerOf(const voxels::ChunkKey& key, const LatticeView& view)
{
    const double size = std::ldexp(double{voxels::kChunkEdge}, static_cast<int>(key.level));
    return glm::dvec3(key.x, key.y, key.z) * size - view.cell;
}

/// The draws of so many nodes of a chunk, in parts that indices can tell apart.
void appendCubes(
    std::vector<VkDrawIndexedIndirectCommand>& draws, std::uint32_t nodes, std::uint32_t chunk)
{
    for (std::uint32_t voxel = 0; voxel < nodes; voxel += kVoxelsInDraw)
        draws.push_back(
            {.indexCount = 18 * std::min(kVoxelsInDraw, nodes - voxel),
             .instanceCount = 1,
             .firstIndex = 0,
             .vertexOffset = static_cast<std::int32_t>(voxel * shared::kCornersOfVoxel),
             .firstInstance = chunk});
}

void append(VoxelFrame& frame, const Candidate& candidate, const LatticeView& view)
{
    const PlacedChunk& chunk = *candidate.chunk;
    const glm::dvec3 corner = cornerOf(chunk.key, view);
    const auto index = static_cast<std::uint32_t>(frame.chunks.size());
    const std::uint32_t nodes = chunk.voxels + chunk.redundant;
    const auto firstBlock = static_cast<std::uint32_t>(frame.blocks.size());
    frame.keys.push_back(chunk.key);
    frame.places.push_back(candidate.place);
    if (chunk.occlusionOnly && candidate.kind != Candidate::box)
        frame.untested.push_back(candidate.place);
    frame.chunks.push_back(
        {.cornerAndLevel = shared::ivec4(glm::ivec3(corner), static_cast<int>(chunk.key.level)),
         .place = {chunk.firstWord, chunk.firstColour, nodes, firstBlock},
         .box =
             {chunk.low | candidate.pictures << shared::kChunkPicturesShift,
              chunk.high,
              chunk.voxels,
              std::bit_cast<std::uint32_t>(chunk.weight)},
         .fade = {
             chunk.firstParent, chunk.firstParent + nodes, chunk.parentWord, chunk.parentColour}});
    if (candidate.kind == Candidate::box) {
        ++frame.boxes;
        return;
    }
    for (std::uint32_t voxel = 0; voxel < nodes; voxel += shared::kVoxelsInBlock)
        frame.blocks.push_back({{index, voxel}});
    frame.stats.voxels += nodes;
    ++frame.stats.chunksDrawn;
    frame.stats.chunksFading += candidate.isInTransition ? 1 : 0;
    if (candidate.kind == Candidate::splat) {
        frame.splatBlocks = static_cast<std::uint32_t>(frame.blocks.size());
        frame.stats.splatted += nodes;
        return;
    }
    const std::size_t before = frame.cubes.size();
    appendCubes(frame.cubes, nodes, index);
    if (candidate.kind == Candidate::fadingCubes)
        frame.fadingCubes += frame.cubes.size() - before;
}

/// The pictures that a chunk is shown in, and shared::kLooksUp if only a part of it is.
std::uint32_t picturesOf(const PlacedChunk& chunk, const VoxelScene& scene)
{
    if (scene.handOver == nullptr || chunk.occlusionOnly)
        return chunk.pictures;
    const double size = std::ldexp(scene.lattice.edge, static_cast<int>(chunk.key.level));
    const glm::dvec3 corner =
        scene.lattice.origin +
        size * double{voxels::kChunkEdge} * glm::dvec3(chunk.key.x, chunk.key.y, chunk.key.z);
    const Owners owners = scene.handOver->ownersAround(
        {corner + size * placeOf(chunk.low), corner + size * (placeOf(chunk.high) + 1.0)},
        chunk.key.level);
    const std::uint32_t pictures = chunk.pictures & owners.voxels;
    return (pictures & owners.meshes) != 0 ? pictures | shared::kLooksUp : pictures;
}

/// Whether, and as what, a chunk is drawn.
std::optional<Candidate> candidateOf(
    const PlacedChunk& chunk,
    const LatticeView& view,
    double near,
    const VoxelScene& scene,
    bool splats,
    std::uint32_t pictures)
{
    const std::uint32_t shownIn = picturesOf(chunk, scene);
    if ((shownIn & pictures) == 0)
        return std::nullopt;
    const Camera& camera = view.camera;
    const double edge = scene.lattice.edge;
    const double size = std::ldexp(1.0, static_cast<int>(chunk.key.level));
    const glm::dvec3 corner = cornerOf(chunk.key, view) - view.within;
    // Half a voxel more on all sides, as boxes are drawn.
    const glm::dvec3 low = corner + size * (placeOf(chunk.low) - 0.5);
    const glm::dvec3 high = corner + size * (placeOf(chunk.high) + 1.5);
    const glm::dvec3 centre = 0.5 * (low + high);
    const glm::dvec3 half = 0.5 * (high - low);
    const bool inside =
        std::all_of(view.sides.begin(), view.sides.end(), [&](const glm::dvec3& side) {
            return glm::dot(side, centre) + glm::dot(glm::abs(side), half) >= 0;
        });
    const double middle = glm::dot(camera.forward, centre);
    const double reach = glm::dot(glm::abs(camera.forward), half);
    if (!inside || (middle + reach) * edge < near)
        return std::nullopt;
    Candidate candidate{.chunk = &chunk};
    candidate.distance = glm::length(glm::max(glm::max(low, -high), glm::dvec3(0.0)));
    const double nearest = middle - reach;
    // The near plane would cut a hole into the box.
    const bool testable = nearest * edge > near;
    const double pixels = size * view.pixels / std::max(nearest, 0.5);
    const bool small = pixels <= static_cast<double>(scene.largestSplat);
    if (chunk.occlusionOnly && testable)
        candidate.kind = Candidate::box;
    else if (
        splats && (scene.way == VoxelWay::splats || (scene.way == VoxelWay::automatic && small)))
        candidate.kind = Candidate::splat;
    candidate.isInTransition = isInTransition(shownIn, pictures);
    if (isFading(shownIn, pictures)) {
        candidate.pictures = shownIn;
        if (candidate.kind == Candidate::cubes)
            candidate.kind = Candidate::fadingCubes;
    }
    return candidate;
}

} // namespace

ShownVoxel voxelNamed(const VoxelFrame& frame, std::uint32_t name)
{
    const shared::uvec2 start = frame.blocks[(name - 1) >> shared::kBlockBits].chunkAndVoxel;
    const std::uint32_t place = (name - 1) & (shared::kVoxelsInBlock - 1);
    return {.chunk = frame.keys[start.x], .voxel = start.y + place, .isThere = true};
}

VoxelFrame voxelFrame(
    const hierarchy::View& view,
    double near,
    const VoxelScene& scene,
    std::span<const PlacedChunk> chunks,
    bool splats,
    std::uint32_t pictures)
{
    VoxelFrame frame;
    frame.listed = chunks.size();
    frame.findsPattern = scene.findsPattern;
    const double edge = scene.lattice.edge;
    if (!isWithinReach(view, scene.lattice)) {
        frame.stats.chunksCulled = chunks.size();
        return frame;
    }
    const LatticeView seen = latticeView(view, scene.lattice);
    const Camera& camera = seen.camera;
    frame.view.eye = row(seen.within, edge);
    frame.view.clipX = row(camera.right * (edge / camera.tangentX), near);
    frame.view.clipY = row(camera.up * (-edge / camera.tangentY));
    frame.view.clipW = row(camera.forward * edge);
    frame.view.cell = shared::ivec4(glm::ivec3(seen.cell), 0);

    std::vector<Candidate> candidates;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        std::optional<Candidate> candidate =
            candidateOf(chunks[i], seen, near, scene, splats, pictures);
        if (!candidate) {
            // nobody knows whether it could be seen if the meshes weren't there
            if (scene.handOver != nullptr && !chunks[i].occlusionOnly)
                frame.untested.push_back(static_cast<std::uint32_t>(i));
            continue;
        }
        candidate->place = static_cast<std::uint32_t>(i);
        candidates.push_back(*candidate);
    }
    frame.stats.chunksCulled = chunks.size() - candidates.size();
    std::sort(candidates.begin(), candidates.end());
    for (const Candidate& candidate : candidates) {
        if (candidate.kind == Candidate::box && frame.boxes == 0)
            frame.firstBox = static_cast<std::uint32_t>(frame.chunks.size());
        append(frame, candidate, seen);
    }
    frame.stats.boxes = frame.boxes;
    return frame;
}

void addCasters(
    VoxelFrame& frame,
    const hierarchy::View& view,
    const VoxelScene& scene,
    const SunBox& sun,
    std::span<const PlacedChunk> chunks)
{
    if (!sun.casts || !isWithinReach(view, scene.lattice))
        return;
    const LatticeView seen = latticeView(view, scene.lattice);
    for (const PlacedChunk& chunk : chunks) {
        const std::uint32_t pictures = picturesOf(chunk, scene);
        if ((pictures & shared::kInPresent) == 0)
            continue;
        const double size = std::ldexp(1.0, static_cast<int>(chunk.key.level));
        const glm::dvec3 corner = cornerOf(chunk.key, seen);
        const glm::dvec3 low = corner - seen.within + size * placeOf(chunk.low);
        const glm::dvec3 high = corner - seen.within + size * (placeOf(chunk.high) + 1.0);
        const glm::dvec3 centre = 0.5 * scene.lattice.edge * (low + high);
        const glm::dvec3 half = 0.5 * scene.lattice.edge * (high - low);
        bool inside = true;
        for (std::size_t i = 0; i < 2; ++i)
            inside = inside && std::abs(glm::dot(sun.axes[i], centre) - sun.centre[i]) <=
                                   sun.halfWidth + glm::dot(glm::abs(sun.axes[i]), half);
        if (!inside)
            continue;
        const auto index = static_cast<std::uint32_t>(frame.chunks.size());
        const std::uint32_t octants = chunk.octants;
        frame.chunks.push_back(
            {.cornerAndLevel = shared::ivec4(glm::ivec3(corner), static_cast<int>(chunk.key.level)),
             .place = {chunk.firstWord, chunk.firstColour, chunk.voxels, 0},
             .box =
                 {chunk.low | pictures << shared::kChunkPicturesShift,
                  chunk.high | octants << shared::kChunkOctantsShift,
                  chunk.voxels,
                  std::bit_cast<std::uint32_t>(1.0F)},
             .fade = {}});
        appendCubes(frame.shadows, chunk.voxels, index);
        frame.stats.shadowVoxels += chunk.voxels;
    }
}

} // namespace isofront::render
