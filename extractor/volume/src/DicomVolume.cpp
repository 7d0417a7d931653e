// Based on: DICOM PS3.3 C.7.6.2 (Image Plane): a slice's place is ImagePositionPatient, its axes
// ImageOrientationPatient. File names and InstanceNumber don't order slices in space.

#include "DicomVolume.h"

#include "Assembly.h"
#include "DicomFile.h"
#include "FileHeader.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace isofront::volume {

namespace {

using core::ErrorCode;
using core::failure;
using raster::SampleType;

constexpr std::size_t kMostFiles = 65536;

using Series = std::vector<DicomFile>;

/// Slices of one size and orientation, by series.
core::Result<std::vector<Series>> seriesOf(
    const std::filesystem::path& folder,
    const LoadOptions& options,
    std::vector<std::string>& notes)
{
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file())
            files.push_back(entry.path());
    if (files.size() > kMostFiles)
        return failure(
            ErrorCode::resourceLimit,
            "the folder has more than " + std::to_string(kMostFiles) +
                " files; put one series into a folder of its own");
    std::sort(files.begin(), files.end());
    std::vector<Series> result;
    std::size_t others = 0;
    std::string reason; // of the first that is DICOM and yet no slice, or else of the first
    for (const std::filesystem::path& path : files) {
        if (const auto stopped = checkStop(options); !stopped)
            return tl::unexpected(stopped.error());
        auto file = readDicomHeader(path);
        if (!file) {
            if (others++ == 0 || reason.ends_with("it is no DICOM file"))
                reason = path.filename().string() + ": " + file.error().message;
            continue;
        }
        const auto isAlike = [&](const Series& series) {
            const DicomFile& first = series.front();
            return first.series == file->series && first.columns == file->columns &&
                   first.rows == file->rows &&
                   glm::distance(first.alongRow, file->alongRow) < 1e-3 &&
                   glm::distance(first.alongColumn, file->alongColumn) < 1e-3;
        };
        const auto found = std::find_if(result.begin(), result.end(), isAlike);
        if (found == result.end())
            result.push_back({std::move(*file)});
        else
            found->push_back(std::move(*file));
    }
    if (result.empty())
        return failure(
            ErrorCode::badData,
            "none of its " + std::to_string(files.size()) +
                " files is a DICOM slice that can be read, or a TIFF file" +
                (reason.empty() ? "; name a folder of slices" : " (" + reason + ")"));
    if (others > 0)
        notes.push_back(std::to_string(others) + " other files were left out (" + reason + ").");
    return result;
}

std::string nameOf(const Series& series)
{
    const DicomFile& first = series.front();
    return "'" + (first.description.empty() ? first.series : first.description) + "' (" +
           std::to_string(series.size()) + " slices of " + std::to_string(first.columns) + " x " +
           std::to_string(first.rows) + ", series " + first.series + ")";
}

/// The series that is asked for: the one with the most slices, or that `options.series` names.
core::Result<Series>
chosenSeries(std::vector<Series> all, const LoadOptions& options, std::vector<std::string>& notes)
{
    std::vector<const Series*> fitting;
    std::string names;
    for (const Series& series : all) {
        names += (names.empty() ? "" : "; ") + nameOf(series);
        const DicomFile& first = series.front();
        if (first.series.find(options.series) != std::string::npos ||
            first.description.find(options.series) != std::string::npos)
            fitting.push_back(&series);
    }
    if (fitting.empty())
        return failure(
            ErrorCode::usage,
            "no series has '" + options.series + "' in its identifier or description; there are " +
                names);
    const Series& chosen =
        **std::max_element(fitting.begin(), fitting.end(), [](const Series* a, const Series* b) {
            return a->size() < b->size();
        });
    notes.push_back("Series " + nameOf(chosen) + ".");
    for (const Series& other : all)
        if (&other != &chosen)
            notes.push_back("Left out: " + nameOf(other) + "; --series chooses.");
    return chosen;
}

/// Sorts slices along the normal of their plane and returns the step from one to the next.
core::Result<glm::dvec3> sorted(Series& series, std::vector<std::string>& notes)
{
    const DicomFile& first = series.front();
    const glm::dvec3 normal = glm::cross(first.alongRow, first.alongColumn);
    std::stable_sort(series.begin(), series.end(), [&](const DicomFile& a, const DicomFile& b) {
        return glm::dot(a.position, normal) < glm::dot(b.position, normal);
    });
    const auto gaps = static_cast<double>(series.size() - 1);
    std::vector<double> steps;
    for (std::size_t i = 1; i < series.size(); ++i)
        steps.push_back(glm::dot(series[i].position - series[i - 1].position, normal));
    std::vector<double> ordered = steps;
    std::nth_element(
        ordered.begin(),
        ordered.begin() + static_cast<std::ptrdiff_t>(ordered.size() / 2),
        ordered.end());
    const double usual = ordered[ordered.size() / 2];
    for (std::size_t i = 0; i < steps.size(); ++i) {
        const std::string where =
            series[i].path.filename().string() + " and " + series[i + 1].path.filename().string();
        if (!(steps[i] > 1e-4 * std::max(usual, 1e-3)))
            return failure(
                ErrorCode::badData,
                where + " lie at the same place; a folder with several times or echoes has to be "
                        "split, or one of its series chosen with --series");
        if (std::abs(steps[i] - usual) > 0.02 * usual) {
            const double missing = std::round(steps[i] / usual) - 1;
            return failure(
                ErrorCode::badData,
                "between " + where + " lie " + std::to_string(steps[i]) + " mm, elsewhere " +
                    std::to_string(usual) + " mm" +
                    (missing >= 1 ? ": " + std::to_string(static_cast<int>(missing)) +
                                        " slices are missing; add them"
                                  : "; resample the series to even steps"));
        }
    }
    const glm::dvec3 step = (series.back().position - series.front().position) / gaps;
    for (std::size_t i = 0; i < series.size(); ++i) {
        const glm::dvec3 expected = series.front().position + static_cast<double>(i) * step;
        if (glm::length(series[i].position - expected) > 0.05 * usual + 1e-3)
            return failure(
                ErrorCode::badData,
                series[i].path.filename().string() +
                    " lies aside of the line through its series' slices; resample the series");
    }
    const double slant = glm::length(step - glm::dot(step, normal) * normal) / glm::length(step);
    if (slant > 1e-3)
        notes.push_back(
            "The slices are shifted against each other, as by a tilted gantry, by " +
            std::to_string(slant) + " of their distance; they are shown where they were taken.");
    return step;
}

/// Whether slope and intercept keep whole numbers whole, in all slices.
bool isWhole(const Series& series)
{
    return std::all_of(series.begin(), series.end(), [](const DicomFile& file) {
        return file.slope == std::round(file.slope) &&
               file.intercept == std::round(file.intercept) && std::abs(file.slope) < 1e6 &&
               std::abs(file.intercept) < 1e9;
    });
}

/// Calls use(slice number, its stored values) for each slice.
template <typename Use>
core::Result<void> forSlices(const Series& series, const LoadOptions& options, const Use& use)
{
    std::vector<std::int64_t> stored(series.front().pixels());
    for (std::size_t k = 0; k < series.size(); ++k) {
        if (auto stopped = checkStop(options); !stopped)
            return stopped;
        if (auto read = readDicomPixels(series[k], stored); !read)
            return read;
        use(k, stored);
    }
    return {};
}

/// The smallest type that has every value of the series after slope and intercept.
core::Result<SampleType> typeFor(const Series& series, const LoadOptions& options)
{
    if (!isWhole(series))
        return SampleType::float32;
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    const auto scanned =
        forSlices(series, options, [&](std::size_t k, const std::vector<std::int64_t>& stored) {
            const auto [least, most] = std::minmax_element(stored.begin(), stored.end());
            for (const std::int64_t value : {*least, *most}) {
                const double scaled =
                    static_cast<double>(value) * series[k].slope + series[k].intercept;
                low = std::min(low, scaled);
                high = std::max(high, scaled);
            }
        });
    if (!scanned)
        return tl::unexpected(scanned.error());
    if (low >= 0 && high <= 255 && series.front().bitsAllocated == 8)
        return SampleType::uint8;
    if (low >= -32768 && high <= 32767)
        return SampleType::int16;
    if (low >= 0 && high <= 65535)
        return SampleType::uint16;
    if (low >= -2147483648.0 && high <= 2147483647.0)
        return SampleType::int32;
    return SampleType::float64;
}

} // namespace

core::Result<DenseVoxels>
readDicomFolder(const std::filesystem::path& folder, const LoadOptions& options)
{
    DenseVoxels dense;
    auto all = seriesOf(folder, options, dense.notes);
    if (!all)
        return tl::unexpected(all.error());
    auto chosen = chosenSeries(std::move(*all), options, dense.notes);
    if (!chosen)
        return tl::unexpected(chosen.error());
    Series& series = *chosen;
    const DicomFile first = series.front();
    if (series.size() < 2)
        return failure(
            ErrorCode::badData, "its series has one slice only; a volume has at least two");
    for (const DicomFile& file : series)
        if (std::abs(file.rowSpacing - first.rowSpacing) > 1e-4 * first.rowSpacing ||
            std::abs(file.columnSpacing - first.columnSpacing) > 1e-4 * first.columnSpacing)
            return failure(
                ErrorCode::badData,
                file.path.filename().string() + " has pixels of another size than " +
                    first.path.filename().string() + "; all slices must be alike");
    const auto step = sorted(series, dense.notes);
    if (!step)
        return tl::unexpected(step.error());

    FileHeader header;
    header.dimensions = {first.columns, first.rows, static_cast<std::int64_t>(series.size())};
    header.voxelBytes = 2; // at least, before the values are known
    if (const auto checked = checkHeader(header, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    const auto type = typeFor(series, options);
    if (!type)
        return tl::unexpected(type.error());
    header.voxelBytes = raster::bytesOf(*type);
    if (const auto checked = checkHeader(header, options.memoryLimit); !checked)
        return tl::unexpected(checked.error());
    if (*type == SampleType::float32)
        dense.notes.push_back("The rescaled values are no whole numbers; they are kept as floats.");

    dense.dimensions = {first.columns, first.rows, static_cast<int>(series.size())};
    dense.worldFromIndex.linear = glm::dmat3(
        first.columnSpacing * first.alongRow, first.rowSpacing * first.alongColumn, *step);
    dense.worldFromIndex.translation = series.front().position;
    auto voxels = readVoxels(
        *type,
        header.dataBytes() / header.voxelBytes,
        dense.notes,
        [&](std::span<std::byte> into) -> core::Result<void> {
            return forSlices(
                series, options, [&](std::size_t k, const std::vector<std::int64_t>& stored) {
                    raster::dispatched(*type, [&](auto zero) {
                        using T = decltype(zero);
                        auto* voxel = reinterpret_cast<T*>(into.data()) + k * stored.size();
                        for (const std::int64_t value : stored)
                            *voxel++ = static_cast<T>(
                                static_cast<double>(value) * series[k].slope + series[k].intercept);
                    });
                });
        });
    if (!voxels)
        return tl::unexpected(voxels.error());
    dense.voxels = std::move(*voxels);
    return dense;
}

} // namespace isofront::volume
