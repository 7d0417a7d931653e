#pragma once

#include "isofront/raster/SampleType.h"

#include <isofront/core/Result.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace isofront::raster {

/// What GeoTIFF tags say, as they stand in the file; empty where a tag is missing.
struct GeoTags {
    std::vector<double> pixelScale;     ///< ModelPixelScaleTag: x, y, z
    std::vector<double> tiepoints;      ///< ModelTiepointTag: column, row, 0, x, y, z, ...
    std::vector<double> transformation; ///< ModelTransformationTag: 4 x 4, by rows
    std::vector<std::uint16_t> keys;    ///< GeoKeyDirectoryTag
    std::string noData;                 ///< GDAL_NODATA: a number as text

    /// The value of a key that is stored in the directory itself.
    [[nodiscard]] std::optional<std::uint16_t> key(std::uint16_t id) const;
};

/// One picture of a TIFF file: rows from the top, one sample a pixel.
struct TiffPage {
    int width = 0;  ///< [px]
    int height = 0; ///< [px]
    SampleType type = SampleType::uint8;
    bool whiteIsZero = false; ///< the file means its values as darkness
    std::string description;  ///< ImageDescription
    /// Pixels for each unit of length, as far as the file says; and the unit: 1 none, 2 inch,
    /// 3 centimetre.
    std::optional<double> xResolution, yResolution;
    int resolutionUnit = 2;
    GeoTags geo;
    std::uint64_t directory = 0; ///< where it is in the file

    [[nodiscard]] std::uint64_t bytes() const
    {
        return static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height) *
               bytesOf(type);
    }
};

/// Reads TIFF files through libtiff: strips and tiles, either byte order, BigTIFF, every
/// compression that libtiff has, one sample a pixel of 8, 16, 32 or 64 bits.
///
/// Thread: one thread an object; objects don't share anything.
class TiffFile {
public:
    /// Reads the directories of all pages. Reduced copies and masks of pages are left out.
    ///
    /// Errors, which don't name the file: inputOutput for what can't be read; badData for what is
    /// no TIFF file, damaged, or has pages that can't be read (several samples a pixel, palettes,
    /// other numbers of bits); resourceLimit if a page takes more than `memoryLimit` bytes. Sizes
    /// are held against the length of the file before any memory is taken.
    static core::Result<TiffFile>
    open(const std::filesystem::path& path, std::uint64_t memoryLimit);

    [[nodiscard]] const std::vector<TiffPage>& pages() const { return _pages; }

    /// The samples of a page, in the byte order of this machine.
    /// @param into  exactly `pages()[page].bytes()` long (asserted)
    /// Errors: badData if the data are damaged or cut short, or the compression is unknown.
    [[nodiscard]] core::Result<void> read(std::size_t page, std::span<std::byte> into) const;

private:
    std::filesystem::path _path;
    std::uint64_t _memoryLimit = 0;
    std::vector<TiffPage> _pages;
};

} // namespace isofront::raster
