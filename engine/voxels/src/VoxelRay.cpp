#include "isofront/voxels/VoxelRay.h"

#include "ChunkCache.h"
#include "ChunkCodec.h"
#include "CutTree.h"
#include "LatticeRay.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace isofront::voxels {

namespace {

/// Rays that one job casts: enough to find the same chunk loaded again and again.
constexpr std::size_t kRaysOfAJob = 256;

bool isUsable(const Ray& ray)
{
    const glm::dvec3& d = ray.direction;
    return std::isfinite(ray.start.x) && std::isfinite(ray.start.y) && std::isfinite(ray.start.z) &&
           std::isfinite(d.x) && std::isfinite(d.y) && std::isfinite(d.z) && d != glm::dvec3(0) &&
           !std::isnan(ray.reach);
}

} // namespace

ChunkCut cutOfLevel(const ChunkStore& store, std::uint32_t level)
{
    ChunkCut cut = store.keys();
    std::erase_if(cut, [&](const ChunkKey& key) { return key.level != level; });
    return cut;
}

struct VoxelRayCaster::Parts {
    Parts(const ChunkStore& store, const ChunkCut& keys, CutTree tree, std::size_t mostBytes)
        : lattice(store.model().lattice), cut(keys), chunks(std::move(tree)),
          cache(store, keys, mostBytes)
    {
    }

    /// Chunks that a thread was in lately, so that it needn't ask the cache for them, which all
    /// threads share: rays beside each other go through the same ones.
    class Recent {
    public:
        /// @return valid until the next call
        core::Result<const LoadedChunk*> get(std::uint32_t index, ChunkCache& cache)
        {
            Entry& entry = _entries[index % _entries.size()];
            if (entry.index != index) {
                auto loaded = cache.get(index);
                if (!loaded)
                    return tl::unexpected(loaded.error());
                entry = {index, std::move(*loaded)};
            }
            return entry.chunk.get();
        }

    private:
        struct Entry {
            std::uint32_t index = CutTree::kNone;
            std::shared_ptr<const LoadedChunk> chunk;
        };
        std::array<Entry, 16> _entries;
    };

    core::Result<std::optional<VoxelHit>> cast(const Ray& ray, Recent& recent);
    [[nodiscard]] static VoxelHit
    hit(const LatticeRay& ray, const LatticeRay::Place& place, const Chunk& chunk);

    VoxelLattice lattice;
    ChunkCut cut;
    CutTree chunks;
    ChunkCache cache;
};

core::Result<std::optional<VoxelHit>> VoxelRayCaster::Parts::cast(const Ray& ray, Recent& recent)
{
    if (!isUsable(ray))
        return core::failure(
            core::ErrorCode::usage,
            "a ray can't be cast: its start and direction must be finite, and its direction not "
            "zero");
    const std::optional<LatticeRay> walk = LatticeRay::from(lattice, ray);
    std::optional<LatticeRay::Place> place = walk ? walk->begin() : std::nullopt;
    if (!place)
        return std::nullopt;
    while (walk->contains(*place)) {
        const CutTree::Found found = chunks.at(place->cell);
        if (found.chunk == CutTree::kNone) {
            walk->leave(*place, found.bits);
            continue;
        }
        const auto loaded = recent.get(found.chunk, cache);
        if (!loaded)
            return tl::unexpected(loaded.error());
        const ChunkOccupancy& occupancy = (*loaded)->occupancy;
        const auto level = static_cast<int>(cut[found.chunk].level);
        const std::array<std::int32_t, 3> entered = place->cell;
        const auto isInside = [&] {
            const std::int32_t apart = (place->cell[0] ^ entered[0]) |
                                       (place->cell[1] ^ entered[1]) |
                                       (place->cell[2] ^ entered[2]);
            return apart >> found.bits == 0;
        };
        do {
            const auto local = [&](std::size_t axis) {
                return static_cast<std::uint32_t>(place->cell[axis]) >> level & (kChunkEdge - 1);
            };
            const int empty = occupancy.emptyAround(local(0), local(1), local(2));
            if (empty == ChunkOccupancy::kFullCube) {
                const VoxelHit result = hit(*walk, *place, (*loaded)->chunk);
                return result.distance <= ray.reach ? std::optional(result) : std::nullopt;
            }
            walk->leave(*place, level + empty);
        } while (isInside());
        if (walk->distance(*place) > ray.reach)
            return std::nullopt;
    }
    return std::nullopt;
}

VoxelHit VoxelRayCaster::Parts::hit(
    const LatticeRay& ray, const LatticeRay::Place& place, const Chunk& chunk)
{
    VoxelHit hit;
    hit.chunk = chunk.key;
    for (std::size_t axis = 0; axis < 3; ++axis)
        hit.place[axis] = static_cast<std::uint32_t>(place.cell[axis]) >> chunk.key.level;
    constexpr std::uint32_t kLast = kChunkEdge - 1;
    const std::uint32_t order =
        packPlace(hit.place[0] & kLast, hit.place[1] & kLast, hit.place[2] & kLast, 0);
    const auto voxel = std::ranges::lower_bound(chunk.voxels, order, {}, &Voxel::order);
    hit.index = static_cast<std::uint32_t>(voxel - chunk.voxels.begin());
    hit.face = ray.face(place);
    hit.distance = ray.distance(place);
    FaceAttributes look{voxel->normal, chunk.colours.empty() ? 0 : chunk.colours[hit.index]};
    if (hit.face)
        look = attributesOf(chunk, hit.index, *hit.face);
    hit.normal = unpackNormal(look.normal);
    if (!chunk.colours.empty())
        hit.colour = look.colour;
    return hit;
}

VoxelRayCaster::VoxelRayCaster(std::unique_ptr<Parts> parts) : _parts(std::move(parts)) {}
VoxelRayCaster::VoxelRayCaster(VoxelRayCaster&&) noexcept = default;
VoxelRayCaster& VoxelRayCaster::operator=(VoxelRayCaster&&) noexcept = default;
VoxelRayCaster::~VoxelRayCaster() = default;

core::Result<VoxelRayCaster> VoxelRayCaster::create(
    const ChunkStore& store, const ChunkCut& cut, const RayCasterSettings& settings)
{
    auto tree = CutTree::create(cut, store.model().lattice.levels);
    if (!tree)
        return tl::unexpected(tree.error());
    std::vector<ChunkKey> stored = store.keys();
    std::ranges::sort(stored);
    for (const ChunkKey& key : cut)
        if (!std::ranges::binary_search(stored, key))
            return core::failure(
                core::ErrorCode::usage,
                "the model has no " + nameOf(key) + ": name only chunks that it has");
    return VoxelRayCaster(
        std::make_unique<Parts>(store, cut, std::move(*tree), settings.cacheBytes));
}

core::Result<std::optional<VoxelHit>> VoxelRayCaster::cast(const Ray& ray) const
{
    Parts::Recent recent;
    return _parts->cast(ray, recent);
}

core::Result<std::vector<std::optional<VoxelHit>>>
VoxelRayCaster::cast(std::span<const Ray> rays, core::Jobs& jobs) const
{
    const std::size_t count = (rays.size() + kRaysOfAJob - 1) / kRaysOfAJob;
    std::vector<std::optional<VoxelHit>> hits(rays.size());
    std::vector<std::optional<core::Error>> errors(count);
    jobs.parallelFor(count, [&](std::size_t job) {
        Parts::Recent recent;
        const std::size_t end = std::min(rays.size(), (job + 1) * kRaysOfAJob);
        for (std::size_t i = job * kRaysOfAJob; i < end; ++i) {
            auto hit = _parts->cast(rays[i], recent);
            if (!hit) {
                errors[job] = std::move(hit.error());
                return;
            }
            hits[i] = *hit;
        }
    });
    for (std::optional<core::Error>& error : errors)
        if (error)
            return tl::unexpected(std::move(*error));
    return hits;
}

RayCasterStatistics VoxelRayCaster::statistics() const
{
    const ChunkCache::Statistics cache = _parts->cache.statistics();
    return {cache.loads, cache.bytes, cache.treeBytes};
}

} // namespace isofront::voxels
