#include <isofront/voxels/ChunkStore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

namespace isofront::voxels {

namespace {

/// Bytes 16 to 19 of every LMDB file of this byte order.
constexpr std::size_t kMagicAt = 16;
constexpr std::array<char, 4> kMagic{'\xde', '\xc0', '\xef', '\xbe'};

} // namespace

core::Result<std::vector<ChunkEntry>> ChunkStore::directory() const
{
    std::vector<ChunkEntry> entries;
    for (const ChunkKey& key : keys()) {
        const auto chunk = get(key);
        if (!chunk)
            return tl::unexpected(chunk.error());
        if (*chunk)
            entries.push_back(entryOf(**chunk));
    }
    return entries;
}

bool isStore(const std::filesystem::path& path)
{
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return std::filesystem::is_regular_file(path / "model.json", ignored);
    if (!std::filesystem::is_regular_file(path, ignored))
        return false;
    std::ifstream file(path, std::ios::binary);
    std::array<char, kMagicAt + kMagic.size()> begin{};
    return file.read(begin.data(), begin.size()) &&
           std::equal(kMagic.begin(), kMagic.end(), begin.begin() + kMagicAt);
}

core::Result<std::unique_ptr<ChunkStore>> openAnyStore(const std::filesystem::path& path)
{
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored) ? openFolderStore(path) : openStore(path);
}

core::Result<core::Box> worldBox(const ChunkStore& store)
{
    const VoxelLattice& lattice = store.model().lattice;
    const auto chunk = store.get({lattice.levels - 1, 0, 0, 0});
    if (!chunk)
        return tl::unexpected(chunk.error());
    core::Box box;
    if (!*chunk)
        return box;
    const double edge = std::ldexp(lattice.edge, static_cast<int>(lattice.levels) - 1);
    for (const Voxel& voxel : (*chunk)->voxels) {
        const glm::dvec3 low = lattice.origin + edge * glm::dvec3(voxel.x(), voxel.y(), voxel.z());
        box.include(low);
        box.include(low + edge);
    }
    return box;
}

} // namespace isofront::voxels
