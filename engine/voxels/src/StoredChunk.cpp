#include "StoredChunk.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace isofront::voxels {

std::uint32_t colourOf(const WeightedColour& sum, float area)
{
    const float opacity = sum[3];
    const auto code = [&](float part) {
        const double c =
            opacity > 0 ? std::clamp(static_cast<double>(part / opacity), 0.0, 1.0) : 0;
        const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
        return static_cast<std::uint32_t>(std::lround(255 * s));
    };
    const double weight = std::max(static_cast<double>(area), 1e-12);
    const double part = std::clamp(static_cast<double>(opacity) / weight, 0.0, 1.0);
    return code(sum[0]) | code(sum[1]) << 8U | code(sum[2]) << 16U |
           static_cast<std::uint32_t>(std::lround(255 * part)) << 24U;
}

namespace {

/// As many face attributes as a face set can tell apart.
constexpr std::size_t kMostAttributes = std::size_t{1} << 26U;

std::uint32_t normalOf(const std::array<float, 3>& sum)
{
    return packNormal({sum[0], sum[1], sum[2]});
}

/// Adds the faces of voxels to a chunk.
class FaceSharing {
public:
    explicit FaceSharing(Chunk& chunk) : _chunk(chunk) {}

    void add(const WeightedFaces& faces, bool coloured)
    {
        const Voxel& voxel = _chunk.voxels[faces.voxel];
        const FaceAttributes mean{voxel.normal, coloured ? _chunk.colours[faces.voxel] : 0};
        Key key;
        std::uint32_t mask = 0;
        for (std::size_t face = 0; face < kFaces; ++face) {
            const WeightedFace& sum = faces.faces[face];
            const bool shown = (voxel.faces() & faceBit(static_cast<Face>(face))) != 0;
            // opposite surfaces of one face say no more than those of the voxel
            if (!shown || (sum.normal[0] == 0 && sum.normal[1] == 0 && sum.normal[2] == 0))
                continue;
            const FaceAttributes own{
                normalOf(sum.normal), coloured ? colourOf(sum.colour, sum.area) : 0};
            if (own == mean)
                continue;
            mask |= faceBit(static_cast<Face>(face));
            key.push_back(own.normal);
            key.push_back(own.colour);
        }
        std::vector<FaceAttributes>& all = _chunk.faceAttributes;
        if (mask == 0 || all.size() + kFaces > kMostAttributes)
            return;
        const auto [known, isNew] = _first.try_emplace(key, static_cast<std::uint32_t>(all.size()));
        for (std::size_t i = 0; isNew && i < key.size(); i += 2)
            all.push_back({key[i], key[i + 1]});
        _chunk.faceSets.push_back({faces.voxel, known->second | mask << 26U});
    }

private:
    /// Normals and colours of a voxel's faces in turn.
    using Key = std::vector<std::uint32_t>;

    Chunk& _chunk;
    std::map<Key, std::uint32_t> _first; ///< where in the chunk's attributes they begin
};

} // namespace

Chunk stored(const ChunkKey& key, const VoxelList& list, bool coloured)
{
    Chunk chunk;
    chunk.key = key;
    chunk.voxels.reserve(list.voxels.size());
    for (std::size_t i = 0; i < list.voxels.size(); ++i) {
        const WeightedVoxel& voxel = list.voxels[i];
        chunk.voxels.push_back({voxel.place, normalOf(voxel.normal)});
        if (coloured)
            chunk.colours.push_back(colourOf(list.colours[i], voxel.area));
    }
    FaceSharing sharing(chunk);
    for (const WeightedFaces& faces : list.faces)
        sharing.add(faces, coloured);
    return chunk;
}

} // namespace isofront::voxels
