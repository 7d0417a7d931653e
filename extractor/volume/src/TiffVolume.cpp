// Based on: ImageJ's use of ImageDescription ("spacing=", "unit="), and OME-TIFF's PhysicalSize
// attributes, as their documentation describes them.

#include "TiffVolume.h"

#include "Assembly.h"
#include "FileHeader.h"
#include "TextHeader.h"

#include <isofront/raster/TiffFile.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <utility>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;

/// One slice: a page of a file.
struct Slice {
    std::size_t file = 0;
    std::size_t page = 0;
};

bool isTiffName(const std::filesystem::path& path)
{
    const std::string name = lowered(path.filename().string());
    return name.ends_with(".tif") || name.ends_with(".tiff");
}

std::vector<std::filesystem::path> filesOf(const std::filesystem::path& path)
{
    if (!std::filesystem::is_directory(path))
        return {path};
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(path))
        if (entry.is_regular_file() && isTiffName(entry.path()))
            files.push_back(entry.path());
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) {
        return comesNaturallyBefore(a.filename().string(), b.filename().string());
    });
    return files;
}

/// The positive number that follows a key in a text.
std::optional<double> numberAfter(const std::string& text, const std::string& key)
{
    const std::size_t found = text.find(key);
    if (found == std::string::npos)
        return std::nullopt;
    double value = 0;
    const char* begin = text.data() + found + key.size();
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    if (error != std::errc() || !(value > 0) || !std::isfinite(value))
        return std::nullopt;
    return value;
}

/// The size of a voxel, where the program that wrote the file has put all of it there.
std::optional<glm::dvec3> voxelSizeOf(const raster::TiffPage& page)
{
    const std::string& text = page.description;
    const auto x = numberAfter(text, "PhysicalSizeX=\"");
    const auto y = numberAfter(text, "PhysicalSizeY=\"");
    const auto z = numberAfter(text, "PhysicalSizeZ=\"");
    if (x && y && z)
        return glm::dvec3(*x, *y, *z);
    const auto spacing = numberAfter(text, "spacing=");
    if (text.starts_with("ImageJ=") && spacing && page.xResolution.value_or(0) > 0 &&
        page.yResolution.value_or(0) > 0)
        return glm::dvec3(1 / *page.xResolution, 1 / *page.yResolution, *spacing);
    return std::nullopt;
}

} // namespace

bool comesNaturallyBefore(const std::string& first, const std::string& second)
{
    const auto isDigit = [](char c) { return c >= '0' && c <= '9'; };
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < first.size() && j < second.size()) {
        if (isDigit(first[i]) && isDigit(second[j])) {
            const auto run = [&](const std::string& text, std::size_t& at) {
                while (at < text.size() && text[at] == '0')
                    ++at;
                const std::size_t begin = at;
                while (at < text.size() && isDigit(text[at]))
                    ++at;
                return std::string_view(text).substr(begin, at - begin);
            };
            const std::string_view a = run(first, i);
            const std::string_view b = run(second, j);
            if (a.size() != b.size())
                return a.size() < b.size();
            if (a != b)
                return a < b;
        } else {
            if (first[i] != second[j])
                return first[i] < second[j];
            ++i;
            ++j;
        }
    }
    if (first.size() - i != second.size() - j)
        return first.size() - i < second.size() - j;
    return first < second; // they differ in leading zeros at most
}

core::Result<DenseVoxels>
readTiffVolume(const std::filesystem::path& path, const LoadOptions& options)
{
    const std::vector<std::filesystem::path> paths = filesOf(path);
    const bool isFolder = std::filesystem::is_directory(path);
    std::vector<raster::TiffFile> files;
    std::vector<Slice> slices;
    const auto named = [&](const core::Error& error, std::size_t file) {
        return tl::unexpected(isFolder ? error.within(paths[file].filename().string()) : error);
    };
    for (std::size_t f = 0; f < paths.size(); ++f) {
        if (const auto stopped = checkStop(options); !stopped)
            return tl::unexpected(stopped.error());
        auto file = raster::TiffFile::open(paths[f], options.memoryLimit);
        if (!file)
            return named(file.error(), f);
        const raster::TiffPage& first = files.empty() ? file->pages()[0] : files[0].pages()[0];
        for (std::size_t p = 0; p < file->pages().size(); ++p) {
            const raster::TiffPage& page = file->pages()[p];
            if (page.width != first.width || page.height != first.height || page.type != first.type)
                return named(
                    {ErrorCode::badData,
                     "page " + std::to_string(p + 1) + " has " + std::to_string(page.width) +
                         " x " + std::to_string(page.height) + " pixels of " +
                         std::string(raster::nameOf(page.type)) + ", the first slice " +
                         std::to_string(first.width) + " x " + std::to_string(first.height) +
                         " of " + std::string(raster::nameOf(first.type)) +
                         "; all slices must be alike"},
                    f);
            slices.push_back({f, p});
        }
        files.push_back(std::move(*file));
    }
    if (slices.size() < 2)
        return failure(
            ErrorCode::badData,
            "it has one slice only; a volume of TIFF files has at least two, in pages or files");

    const raster::TiffPage& first = files[0].pages()[0];
    DenseVoxels dense;
    FileHeader header;
    header.dimensions = {first.width, first.height, static_cast<std::int64_t>(slices.size())};
    header.voxelBytes = raster::bytesOf(first.type);
    if (const auto checked = checkHeader(header, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    dense.dimensions = {first.width, first.height, static_cast<int>(slices.size())};
    if (!options.voxelSize) {
        const auto size = voxelSizeOf(first);
        if (!size)
            return failure(
                ErrorCode::usage,
                "TIFF files don't say how far apart their slices are; give --voxel-size X,Y,Z in "
                "the unit that you want the surface in");
        for (std::size_t axis = 0; axis < 3; ++axis)
            dense.worldFromIndex.linear[axis][axis] = (*size)[axis];
    }
    dense.notes.push_back(
        isFolder ? std::to_string(slices.size()) + " slices in the natural order of their names, " +
                       paths.front().filename().string() + " to " +
                       paths.back().filename().string() + "."
                 : std::to_string(slices.size()) + " slices in the order of the pages.");
    if (first.whiteIsZero)
        dense.notes.push_back(
            "The file means low values as white; they are taken as the numbers that they are.");

    auto voxels = readVoxels(
        first.type,
        header.dataBytes() / header.voxelBytes,
        dense.notes,
        [&](std::span<std::byte> into) -> core::Result<void> {
            for (const Slice& slice : slices) {
                if (auto stopped = checkStop(options); !stopped)
                    return stopped;
                const std::uint64_t bytes = first.bytes();
                if (const auto read = files[slice.file].read(slice.page, into.first(bytes)); !read)
                    return named(read.error(), slice.file);
                into = into.subspan(bytes);
            }
            return {};
        });
    if (!voxels)
        return tl::unexpected(voxels.error());
    dense.voxels = std::move(*voxels);
    return dense;
}

} // namespace isofront::volume
