#include "SceneFiles.h"

#include "../api/Message.h"

#include <isofront/elevation/LoadElevation.h>
#include <isofront/fields/Procedural.h>
#include <isofront/volume/LoadVolume.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <span>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;
using namespace std::string_view_literals;

constexpr std::size_t kMostVisited = 200'000;
/// Headers that are text end long before.
constexpr std::size_t kMostHeader = std::size_t{1} << 20U;
/// What all readers take whole.
constexpr std::size_t kLongestLine = 400;

std::string lowered(std::string text)
{
    for (char& c : text)
        c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    return text;
}

bool endsWithAny(const std::string& name, std::span<const std::string_view> ends)
{
    const std::string lower = lowered(name);
    return std::ranges::any_of(ends, [&](std::string_view end) { return lower.ends_with(end); });
}

/// Files that hold all that their readers read.
constexpr std::array kVolumeUploads{".nrrd"sv, ".nii"sv, ".nii.gz"sv, ".mha"sv, ".vdb"sv};
constexpr std::array kRawUploads{".raw"sv, ".raw.gz"sv};
constexpr std::array kTiffUploads{".tif"sv, ".tiff"sv}; // volumes or elevation
constexpr std::array kElevationUploads{".hgt"sv, ".hgt.gz"sv, ".png"sv};
constexpr std::array kMeshUploads{
    ".ply"sv, ".ply.gz"sv, ".glb"sv, ".glb.gz"sv, ".stl"sv, ".stl.gz"sv, ".obj"sv, ".obj.gz"sv};
constexpr std::array<std::span<const std::string_view>, 5> kUploads{
    kVolumeUploads, kRawUploads, kTiffUploads, kElevationUploads, kMeshUploads};
/// Those beside other files, which are found among the sources too.
constexpr std::array kVolumeHeaders{".nhdr"sv, ".mhd"sv};
constexpr std::array kMeshHeaders{".gltf"sv};

bool isUpload(const std::string& name)
{
    return std::ranges::any_of(kUploads, [&](auto ends) { return endsWithAny(name, ends); });
}

/// No hidden one, none that leads up, and none that JSON can't tell.
bool isNameForClients(const std::string& name)
{
    return !name.starts_with('.') && isPlainText(name);
}

bool isSource(const std::string& name)
{
    return isUpload(name) || endsWithAny(name, kVolumeHeaders) || endsWithAny(name, kMeshHeaders);
}

/// Whether a file without an extension that says so begins as DICOM files do.
bool beginsAsDicom(const fs::path& path)
{
    std::array<char, 132> head{};
    std::ifstream in(path, std::ios::binary);
    in.read(head.data(), head.size());
    return in.gcount() == static_cast<std::streamsize>(head.size()) &&
           std::string_view(head.data() + 128, 4) == "DICM";
}

/// What a folder has that scenes can be made of. Links are left out, because they may lead
/// anywhere, and so are hidden names and those that no client can write.
struct Contents {
    std::vector<std::string> folders;
    std::vector<SourceFile> files;
    bool hasSlices = false; ///< is a volume itself
};

/// @param visits  how many entries may still be looked at
Contents contentsOf(const fs::path& folder, std::size_t& visits)
{
    constexpr std::array<std::string_view, 4> kSlices{".dcm", ".ima", ".tif", ".tiff"};
    constexpr std::size_t kMostOpened = 16; // files that may be slices by another name
    Contents contents;
    std::size_t slices = 0;
    std::size_t opened = 0;
    std::error_code error;
    fs::directory_iterator entry(folder, fs::directory_options::skip_permission_denied, error);
    for (; !error && entry != fs::directory_iterator() && visits > 0; entry.increment(error)) {
        --visits;
        std::string name = entry->path().filename().string();
        std::error_code ignored;
        const fs::file_status status = entry->symlink_status(ignored);
        if (!isNameForClients(name))
            continue;
        if (fs::is_directory(status)) {
            contents.folders.push_back(std::move(name));
        } else if (fs::is_regular_file(status)) {
            if (slices < 2)
                slices +=
                    endsWithAny(name, kSlices) || (!isSource(name) && opened++ < kMostOpened &&
                                                   beginsAsDicom(entry->path()))
                        ? 1U
                        : 0U;
            if (isSource(name))
                contents.files.push_back({std::move(name), entry->file_size(ignored)});
        }
    }
    contents.hasSlices = slices > 1;
    return contents;
}

} // namespace

SourceFiles sourceFilesIn(const fs::path& folder, std::size_t most)
{
    SourceFiles found;
    std::size_t visits = kMostVisited;
    std::vector<std::string> folders{""}; // with a slash at the end, but for the first
    while (!folders.empty() && visits > 0 && found.files.size() <= most) {
        const std::string at = std::move(folders.back());
        folders.pop_back();
        Contents contents = contentsOf(folder / at, visits);
        if (contents.hasSlices && !at.empty())
            found.files.push_back({at.substr(0, at.size() - 1), 0});
        for (SourceFile& file : contents.files)
            found.files.push_back({at + file.path, file.bytes});
        for (const std::string& name : contents.folders)
            folders.push_back(at + name + "/");
    }
    std::ranges::sort(found.files, {}, &SourceFile::path);
    found.isComplete = folders.empty() && visits > 0 && found.files.size() <= most;
    found.files.resize(std::min(found.files.size(), most));
    return found;
}

SourceFiles SourceFolder::files()
{
    const std::scoped_lock lock(_mutex); // one walk serves all who wait for it
    using Clock = std::chrono::steady_clock;
    const Clock::time_point begin = Clock::now();
    if (!_folder.empty() && begin >= _nextWalk) {
        _files = sourceFilesIn(_folder);
        const Clock::time_point end = Clock::now();
        _nextWalk = end + 10 * (end - begin);
    }
    return _files;
}

core::Result<fs::path> sourceFileIn(const fs::path& folder, const std::string& path)
{
    const auto refused = [&] {
        return core::failure(
            core::ErrorCode::usage, "there is no file '" + path + "' among the sources");
    };
    if (folder.empty() || path.empty() || fs::path(path).is_absolute())
        return refused();
    std::error_code error;
    fs::path found = fs::canonical(folder, error);
    if (error)
        return refused();
    fs::file_status status;
    for (const fs::path& part : fs::path(path)) {
        if (part.empty() && fs::is_directory(status))
            continue; // behind a slash at the end
        status = fs::symlink_status(found /= part, error);
        if (error || !isNameForClients(part.string()))
            return refused();
    }
    std::size_t visits = kMostVisited;
    const bool isThere = fs::is_directory(status)
                             ? contentsOf(found, visits).hasSlices
                             : fs::is_regular_file(status) && isSource(found.filename().string());
    return isThere ? core::Result<fs::path>(found) : refused();
}

core::Result<std::string> uploadName(const std::string& name)
{
    std::string safe;
    for (const char c : fs::path(name).filename().string())
        safe += (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                        c == '.' || c == '-' || c == '_'
                    ? c
                    : '_';
    if (safe.size() > 100)
        safe.erase(0, safe.size() - 100);
    while (safe.starts_with('.'))
        safe.erase(0, 1);
    if (isUpload(safe))
        return safe;
    std::string kinds;
    for (const auto ends : kUploads)
        for (const std::string_view end : ends)
            kinds += (kinds.empty() ? "" : " ") + std::string(end);
    return core::failure(
        core::ErrorCode::usage,
        "'" + name + "' is not of a kind that can be uploaded: there are " + kinds +
            "; what consists of several files belongs into the service's folder of sources");
}

core::Result<void>
checkOptions(const sources::SourceOptions& options, const SceneOrigin& origin, bool isFolder)
{
    const std::string& name = origin.text;
    const bool isFormula = origin.kind == SceneOrigin::Kind::procedural;
    const auto isAny = [&](std::span<const std::string_view> ends) {
        return !isFormula && !isFolder && endsWithAny(name, ends);
    };
    const bool isRaw = isAny(kRawUploads);
    const bool isTiff = isAny(kTiffUploads);
    const bool isMesh = isAny(kMeshUploads) || isAny(kMeshHeaders);
    const bool isVdb = isAny(std::array{".vdb"sv});
    const bool isElevation = isAny(kElevationUploads);
    const bool isDense =
        isFolder || isRaw || isTiff || isAny(kVolumeHeaders) || (isAny(kVolumeUploads) && !isVdb);
    const sources::SourceOptions none;
    const struct {
        const char* name;
        bool isGiven;
        bool hasEffect;
        const char* of;
    } all[] = {
        {"grid", options.grid != none.grid, isVdb, ".vdb files"},
        {"series", options.series != none.series, isFolder, "folders of DICOM slices"},
        {"raw", options.rawLayout != none.rawLayout, isRaw, ".raw files"},
        {"voxel_size", options.voxelSize.has_value(), isDense, "volumes, .vdb aside"},
        {"detail", options.detail != none.detail, isElevation || isTiff, "elevation rasters"},
        {"pixel_size", options.pixelSize.has_value(), isElevation || isTiff, "elevation rasters"},
        {"height_scale",
         options.heightScale.has_value(),
         isElevation || isTiff,
         "elevation rasters"},
        {"no_data", options.noData.has_value(), isElevation || isTiff, "elevation rasters"},
        {"mesh_resolution", options.meshResolution != none.meshResolution, isMesh, "meshes"},
        {"mesh_reach", options.meshReach.has_value(), isMesh, "meshes"}};
    for (const auto& option : all)
        if (option.isGiven && !option.hasEffect)
            return core::failure(
                core::ErrorCode::usage,
                "options: '" + std::string(option.name) + "' is one of " + option.of +
                    ", and means nothing to '" + name + "'");
    return {};
}

core::Result<void> checkSelfContained(const fs::path& file)
{
    const std::string name = lowered(file.filename().string());
    const bool isNrrd = name.ends_with(".nrrd");
    if (!isNrrd && !name.ends_with(".mha"))
        return {};
    const auto refused = core::failure(
        core::ErrorCode::badData,
        "its header names other files, has no end, or is no plain text: only files that hold "
        "their own voxels can be uploaded");
    std::string head(kMostHeader, '\0');
    std::ifstream in(file, std::ios::binary);
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(in.gcount(), 0)));
    for (std::size_t begin = 0; begin < head.size();) {
        const std::size_t end = head.find('\n', begin);
        if (end == std::string::npos)
            return refused;
        std::string line = head.substr(begin, end - begin);
        begin = end + 1;
        if (line.ends_with('\r'))
            line.pop_back();
        // Libraries differ in what ends a line and how long one may be; so no line may be read in
        // two ways.
        const bool isPlain = std::ranges::none_of(
            line, [](char c) { return (c >= 0 && c < 0x20 && c != '\t') || c == 0x7f; });
        if (!isPlain || line.size() > kLongestLine)
            return refused;
        if (isNrrd && line.empty())
            return {}; // the voxels follow
        std::string key = lowered(line.substr(0, line.find_first_of(":=")));
        std::erase(key, ' ');
        std::erase(key, '\t');
        if (isNrrd && key == "datafile")
            return refused;
        if (!isNrrd && key == "elementdatafile") {
            std::string value = lowered(line.substr(std::min(line.find('=') + 1, line.size())));
            std::erase(value, ' ');
            return value == "local" ? core::Result<void>() : refused;
        }
    }
    return refused;
}

core::Result<void> checkFormula(const std::string& text)
{
    constexpr std::string_view kPrefix = "proc:";
    const std::size_t question = std::min(text.find('?'), text.size());
    const std::string name =
        text.starts_with(kPrefix) ? text.substr(kPrefix.size(), question - kPrefix.size()) : "";
    const auto& known = fields::proceduralSources();
    const auto source = std::ranges::find(known, name, &fields::ProceduralDescription::name);
    if (source == known.end())
        return core::failure(
            core::ErrorCode::usage,
            "'" + text + "' is no formula: write proc:NAME?key=value; /v1/formulas has the names");
    for (const auto& parameter : source->parameters) {
        const bool isChoice = !parameter.choices.empty();
        if (parameter.fileSuffix.empty())
            continue;
        const std::string key = parameter.name + "=";
        for (std::size_t at = text.find(key, question); at != std::string::npos;
             at = text.find(key, at + 1)) {
            const std::size_t begin = at + key.size();
            const std::string value =
                text.substr(begin, std::min(text.find('&', begin), text.size()) - begin);
            if (!isChoice || std::ranges::find(parameter.choices, value) == parameter.choices.end())
                return core::failure(
                    core::ErrorCode::usage,
                    "'" + value + "': formulas that are files aren't read for clients");
        }
    }
    // making a field takes no time: it is not looked at yet
    const auto made = sources::openSource(text, {});
    return made ? core::Result<void>() : tl::unexpected(made.error());
}

} // namespace isofront::server
