#include "isofront/voxels/ChunkForm.h"

#include <isofront/core/Assert.h>

#include <array>
#include <cstring>
#include <vector>

namespace isofront::voxels {

namespace {

constexpr std::uint32_t kNormalBits = 30;
constexpr std::uint32_t kNormalMask = (1U << kNormalBits) - 1;
constexpr std::uint32_t kPlaceBits = 28;
constexpr std::size_t kWord = sizeof(std::uint32_t);

/// The places of a chunk's parts, in words from its first.
struct Parts {
    std::size_t colours, attributes, sets;

    explicit Parts(const Chunk& chunk)
        : colours(chunk.voxels.size() * sizeof(Voxel) / kWord),
          attributes(colours + chunk.colours.size()),
          sets(attributes + chunk.faceAttributes.size() * sizeof(FaceAttributes) / kWord)
    {
    }
};

template <typename T>
void copy(std::span<std::byte> to, std::size_t word, const std::vector<T>& from)
{
    if (!from.empty())
        std::memcpy(to.data() + word * kWord, from.data(), from.size() * sizeof(T));
}

} // namespace

void packInto(const Chunk& chunk, std::span<std::byte> place)
{
    const Parts parts(chunk);
    ISOFRONT_ASSERT(place.size() == chunk.bytes(), "a chunk in a place of another size");
    std::vector<Voxel> voxels(chunk.voxels.size());
    const std::vector<std::uint8_t> faces = cappedFaces(chunk);
    for (std::size_t i = 0; i < voxels.size(); ++i) {
        const Voxel& voxel = chunk.voxels[i];
        voxels[i] = {
            packPlace(voxel.x(), voxel.y(), voxel.z(), faces[i]), voxel.normal & kNormalMask};
    }
    std::vector<std::array<std::uint32_t, 2>> sets;
    sets.reserve(chunk.faceSets.size());
    for (const FaceSet& set : chunk.faceSets) {
        const auto at = static_cast<std::uint32_t>(parts.sets + 2 * sets.size());
        const auto first = static_cast<std::uint32_t>(parts.attributes + 2 * set.first());
        const std::uint32_t mask = set.mask();
        // at most 3 * 2^24 for voxels, and 2^27 for attributes
        ISOFRONT_ASSERT(first >> kPlaceBits == 0, "a chunk has more voxels than places");
        std::uint32_t& normal = voxels[set.voxel].normal;
        sets.push_back({normal | (mask & 3U) << kNormalBits, first | (mask >> 2U) << kPlaceBits});
        normal = kHasFaces | at;
    }
    copy(place, 0, voxels);
    copy(place, parts.colours, chunk.colours);
    copy(place, parts.attributes, chunk.faceAttributes);
    copy(place, parts.sets, sets);
}

ChunkForm standardForm()
{
    return {.bytes = [](const ChunkEntry& entry) { return entry.bytes; }, .pack = packInto};
}

} // namespace isofront::voxels
