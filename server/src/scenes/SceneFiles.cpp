#include "SceneFiles.h"

#include <isofront/elevation/LoadElevation.h>
#include <isofront/fields/Procedural.h>
#include <isofront/volume/LoadVolume.h>

#include <algorithm>
#include <array>
#include <fstream>

namespace isofront::server {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostFiles = 10'000;
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
constexpr std::array<std::string_view, 12> kUploads{
    ".nrrd",
    ".nii",
    ".nii.gz",
    ".mha",
    ".vdb",
    ".hgt",
    ".hgt.gz",
    ".tif",
    ".tiff",
    ".png",
    ".raw",
    ".raw.gz"};
/// Headers beside their data, which are found among the sources too.
constexpr std::array<std::string_view, 2> kHeaders{".nhdr", ".mhd"};

bool isSource(const fs::path& path)
{
    const std::string name = path.filename().string();
    return endsWithAny(name, kUploads) || endsWithAny(name, kHeaders);
}

bool isSlice(const fs::path& path)
{
    constexpr std::array<std::string_view, 3> kSlices{".dcm", ".tif", ".tiff"};
    return endsWithAny(path.filename().string(), kSlices);
}

} // namespace

std::vector<SourceFile> sourceFilesIn(const fs::path& folder)
{
    std::vector<SourceFile> files;
    std::error_code error;
    fs::recursive_directory_iterator entry(
        folder, fs::directory_options::skip_permission_denied, error);
    std::size_t visited = 0;
    for (; !error && entry != fs::recursive_directory_iterator() && files.size() < kMostFiles &&
           ++visited < kMostVisited;
         entry.increment(error)) {
        std::error_code ignored;
        if (entry->path().filename().string().starts_with('.')) {
            entry.disable_recursion_pending();
            continue;
        }
        const std::string path = entry->path().lexically_relative(folder).generic_string();
        if (entry->is_directory(ignored)) {
            std::size_t slices = 0;
            fs::directory_iterator one(entry->path(), ignored);
            for (; !ignored && slices < 2 && one != fs::directory_iterator();
                 one.increment(ignored))
                slices += isSlice(one->path()) ? 1U : 0U;
            if (slices > 1)
                files.push_back({path, 0});
        } else if (entry->is_regular_file(ignored) && isSource(entry->path())) {
            files.push_back({path, entry->file_size(ignored)});
        }
    }
    std::ranges::sort(files, {}, &SourceFile::path);
    return files;
}

core::Result<fs::path> sourceFileIn(const fs::path& folder, const std::string& path)
{
    const auto refused = [&] {
        return core::failure(
            core::ErrorCode::usage, "there is no file '" + path + "' among the sources");
    };
    if (folder.empty() || path.empty() || path.find('\0') != std::string::npos ||
        fs::path(path).is_absolute())
        return refused();
    std::error_code error;
    const fs::path root = fs::canonical(folder, error);
    if (error)
        return refused();
    const fs::path found = fs::canonical(root / path, error);
    if (error)
        return refused();
    const auto [inRoot, inFound] = std::ranges::mismatch(root, found);
    if (inRoot != root.end() || inFound == found.end())
        return refused();
    // what isn't listed isn't there
    const bool isHidden = std::any_of(
        inFound, found.end(), [](const fs::path& part) { return part.string().starts_with('.'); });
    if (isHidden || !(isSource(found) || fs::is_directory(found, error)))
        return refused();
    return found;
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
    if (endsWithAny(safe, kUploads) && safe.find('.') != 0)
        return safe;
    std::string kinds;
    for (const std::string_view end : kUploads)
        kinds += (kinds.empty() ? "" : " ") + std::string(end);
    return core::failure(
        core::ErrorCode::usage,
        "'" + name + "' is not of a kind that can be uploaded: there are " + kinds +
            "; volumes of several files belong into the service's folder of sources");
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
    return {};
}

} // namespace isofront::server
