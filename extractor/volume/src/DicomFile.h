#pragma once

#include <isofront/core/Result.h>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace isofront::volume {

/// What the header of a DICOM file says of its picture, a slice of one number a pixel.
struct DicomFile {
    std::filesystem::path path;
    int columns = 0;
    int rows = 0;
    int bitsAllocated = 16; ///< 8, 16 or 32
    int bitsStored = 16;    ///< of them, the lowest
    bool isSigned = false;
    bool bigEndian = false;
    double slope = 1;
    double intercept = 0;
    glm::dvec3 position{0.0};        ///< of the first pixel's centre [mm, LPS]
    glm::dvec3 alongRow{1, 0, 0};    ///< unit vectors in which columns ...
    glm::dvec3 alongColumn{0, 1, 0}; ///< ... and rows are counted
    double columnSpacing = 1;        ///< distance of neighbouring columns [mm]
    double rowSpacing = 1;           ///< distance of neighbouring rows [mm]
    std::string series;              ///< SeriesInstanceUID
    std::string description;         ///< SeriesDescription
    std::uint64_t pixelOffset = 0;   ///< [bytes] in the file
    /// [bytes] that the pixels take as runs; 0 if they are stored as they are
    std::uint64_t packedBytes = 0;

    [[nodiscard]] std::size_t pixels() const
    {
        return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
    }
};

/// Reads a file's header. Every length is held against the size of the file.
///
/// Errors say why a file is no slice that can be read, without naming it. Pixels are stored as they
/// are or as runs; other ways to compress them are refused by name. A file has one frame.
/// Source: DICOM PS3.5 (data elements) and PS3.10 (files), by the letter. Differs: a library was
/// tried, and ends the program on some damaged files.
core::Result<DicomFile> readDicomHeader(const std::filesystem::path& path);

/// The stored numbers of the picture, before slope and intercept.
/// @param into  `file.pixels()` long (asserted)
core::Result<void> readDicomPixels(const DicomFile& file, std::span<std::int64_t> into);

} // namespace isofront::volume
