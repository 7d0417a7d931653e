#pragma once

#include <isofront/core/Box.h>
#include <isofront/core/Result.h>
#include <isofront/sources/Source.h>

#include <glm/vec3.hpp>
#include <nlohmann/json.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace isofront::server {

/// Where a scene's field comes from.
struct SceneOrigin {
    enum class Kind {
        procedural, ///< `text` is a formula, "proc:NAME?key=value"
        file,       ///< `text` is a path below the folder of sources
        upload,     ///< `text` is the name of a file that belongs to the scene
    };
    Kind kind = Kind::procedural;
    std::string text;
    sources::SourceOptions options; ///< what its reader is told; limit and stop aside
};

/// How a field's values are distributed, in the source's own units.
struct Histogram {
    static constexpr std::size_t kBins = 256;

    double low = 0; ///< least finite value
    double high = 0;
    std::array<std::uint64_t, kBins> counts{}; ///< bins of equal width that divide [low, high]
};

/// What there is to know of a scene before any of its surface is shown.
struct SceneDescription {
    std::string kind; ///< "procedural", "volume", "mesh" or "elevation"
    std::string text; ///< a few words
    core::Box bounds; ///< of what there is to see [world]
    double isovalue = 0;
    Histogram values;
    glm::dvec3 eye{0.0}; ///< a good place to look from [world]
    glm::dvec3 target{0.0};
    glm::dvec3 up{0.0, 0.0, 1.0};
    bool isTerrain = false;
    std::vector<std::string> notes;
    std::uint64_t memoryBytes = 0; ///< of the field, once open
};

/// A scene, as it is kept on the disk and told to clients.
struct SceneRecord {
    enum class State { preparing, ready, failed };

    std::string id;      ///< 32 hexadecimal digits
    std::string name;    ///< for people
    std::string created; ///< "2026-11-22T20:00:00.012345Z"; no two the same
    SceneOrigin origin;
    std::uint64_t storedBytes = 0; ///< of an upload
    State state = State::preparing;
    std::uint32_t attempts = 0; ///< how often it has been looked at
    std::string failure;        ///< why, if it failed
    std::optional<SceneDescription> description;
};

/// What clients are told.
nlohmann::ordered_json toJson(const SceneRecord& record, bool isWhole);
/// What is kept on the disk; `parseRecord` reads it.
std::string toText(const SceneRecord& record);
core::Result<SceneRecord> parseRecord(const std::string& text);

/// Reads the options of a source as clients and records write them: `grid`, `series`, `raw`,
/// `detail` (texts), `voxel_size` (three numbers), `pixel_size` (two), `height_scale`, `no_data`,
/// `mesh_resolution`, `mesh_reach`.
core::Result<sources::SourceOptions> parseOptions(const nlohmann::ordered_json& json);
nlohmann::ordered_json optionsToJson(const sources::SourceOptions& options);

/// Looks at an open source. Volumes know how their voxels are distributed; other fields are sampled
/// on a grid of 64^3 points.
SceneDescription describe(const sources::Source& source);

} // namespace isofront::server
