#include "ChunkLists.h"

#include <string>
#include <utility>

namespace isofront::render {

core::Result<std::vector<PlacedChunk>> placedIn(
    const VoxelStore& store,
    std::span<const voxels::ChunkDraw> draws,
    const voxels::ChunkTree& tree)
{
    std::vector<PlacedChunk> chunks;
    for (const voxels::ChunkDraw& draw : draws) {
        if (!isWithin(draw, tree, store.buffer().bytes()))
            return core::failure(
                core::ErrorCode::usage,
                "a streamed chunk lies outside the renderer's voxel pool; make the streamer's "
                "cache no larger than that");
        chunks.push_back(placed(draw, tree));
    }
    return chunks;
}

core::Result<std::vector<PlacedChunk>> chunksOf(const VoxelStore& store, const VoxelScene& shown)
{
    const auto refused = [](const std::string& why) {
        return core::failure(core::ErrorCode::usage, why);
    };
    const bool isStreamed = !shown.placed.empty() || !shown.casters.empty();
    if (isStreamed && (!shown.draws.empty() || shown.tree == nullptr))
        return refused("streamed chunks are drawn with their tree, and without others besides");
    std::vector<PlacedChunk> chunks;
    if (!shown.placed.empty()) {
        core::Result<std::vector<PlacedChunk>> streamed =
            placedIn(store, shown.placed, *shown.tree);
        if (!streamed)
            return streamed;
        chunks = std::move(*streamed);
    }
    for (const VoxelDraw& draw : shown.draws) {
        const PlacedChunk* chunk = store.find(draw.key);
        if (chunk == nullptr)
            return refused(
                "a chunk of level " + std::to_string(draw.key.level) +
                " is to be drawn that is not on the device; add it first");
        chunks.push_back(*chunk);
        chunks.back().occlusionOnly = draw.occlusionOnly;
        chunks.back().pictures = picturesOf(draw);
        if (draw.weight < 1)
            store.fade(chunks.back(), draw.weight);
    }
    return chunks;
}

} // namespace isofront::render
