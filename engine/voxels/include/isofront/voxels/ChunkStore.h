#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/ChunkDirectory.h>
#include <isofront/voxels/ChunkSink.h>
#include <isofront/voxels/ModelSource.h>
#include <isofront/voxels/Voxelization.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace isofront::voxels {

/// Of which field a model is the surface, as whoever made it says.
struct ModelField {
    std::string source;         ///< in one way of writing, to be compared
    double isovalue = 0;        ///< in the source's own units, finite
    double filter = 0;          ///< strength of the low-pass filter, finite
    bool closed = false;        ///< at the border of the data
    std::uint64_t checksum = 0; ///< of the field's values

    friend bool operator==(const ModelField&, const ModelField&) = default;
};

/// What a model of chunks is, kept beside them.
struct StoredModel {
    std::string name;            ///< of what it was made from
    VoxelLattice lattice;        ///< where its voxels lie
    std::uint64_t voxels = 0;    ///< of level 0
    std::uint64_t allVoxels = 0; ///< of all levels
    std::uint64_t chunks = 0;    ///< of all levels
    bool coloured = false;
    Separability separability = Separability::six;
    /// The mesh file that it was made from, whose coordinates are the world's; none for fields, and
    /// for models that were made before this was kept.
    std::optional<ModelSource> source = {};
    /// The field that it is of; none for meshes, and for models that were made before this was
    /// kept.
    std::optional<ModelField> field = {};

    friend bool operator==(const StoredModel&, const StoredModel&) = default;
};

/// Where the chunks of a model are kept.
///
/// A store is written once: chunks first, in any order of keys, then what the model is. One that
/// doesn't say so was not finished, and isn't opened for reading.
///
/// Thread: any number may read at once; one writes.
class ChunkStore : public ChunkSink {
public:
    /// Says what the model is and makes everything durable. Nothing comes after it.
    virtual std::optional<core::Error> finish(const StoredModel& model) = 0;

    [[nodiscard]] virtual const StoredModel& model() const = 0;
    /// For messages: the file or folder that it lies in; without one, the model's name.
    [[nodiscard]] virtual std::string place() const { return model().name; }
    /// The names of all chunks, by level, then by z, y and x.
    [[nodiscard]] virtual std::vector<ChunkKey> keys() const = 0;
    /// What there is to know of all chunks, in any order. Stores keep it apart, and fail with
    /// `badData` if that part is damaged; without one of its own, a store has to read all chunks.
    [[nodiscard]] virtual core::Result<std::vector<ChunkEntry>> directory() const;
    /// A chunk; nothing if the store has none of that name. A damaged one is `badData`, and its
    /// message names it: its parent may stand for it.
    [[nodiscard]] virtual core::Result<std::optional<Chunk>> get(const ChunkKey& key) const = 0;
};

/// A store in memory, for tests and for models that are not kept.
std::unique_ptr<ChunkStore> memoryStore();

/// A store in one LMDB file. What was committed, every few megabytes, survives if the process or
/// the machine goes down; until `finish` the file has another name, with `.part` behind it, and an
/// earlier one stays as it was. Destroyed without `finish`, it leaves nothing behind.
///
/// Fails with `inputOutput` if the file can't be made or read, or another process is making it;
/// with `badData` if it is damaged, something else, of another version, or unfinished.
core::Result<std::unique_ptr<ChunkStore>> createStore(const std::filesystem::path& path);
core::Result<std::unique_ptr<ChunkStore>> openStore(const std::filesystem::path& path);

/// A store in a folder, a file for each chunk: for web servers and for those who look. It, too, is
/// made under a name with `.part` behind it; a folder that is not empty is not replaced. What a
/// process that was killed has left under that name is, as the file is, too, but nothing that isn't
/// a model's.
core::Result<std::unique_ptr<ChunkStore>> createFolderStore(const std::filesystem::path& path);
core::Result<std::unique_ptr<ChunkStore>> openFolderStore(const std::filesystem::path& path);

/// Whether a path names one of both, finished or not, as far as its first bytes tell: a file of
/// LMDB, or a folder with the description of a model.
bool isStore(const std::filesystem::path& path);
/// Opens either kind.
core::Result<std::unique_ptr<ChunkStore>> openAnyStore(const std::filesystem::path& path);

/// The box of a model's voxels, as far as the coarsest level knows it [world]. Fails as `get` does.
core::Result<core::Box> worldBox(const ChunkStore& store);

} // namespace isofront::voxels
