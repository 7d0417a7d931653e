#pragma once

#include "support/FileBytes.h"
#include "support/TemporaryFolder.h"

#include <isofront/core/Box.h>
#include <isofront/fields/Field.h>

#include <glm/vec3.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <random>
#include <span>
#include <string>
#include <vector>

namespace isofront::test {

using tests::bytesOf;
using tests::gzipped;
using tests::TemporaryFolder;
std::string zlibbed(const std::string& bytes);

/// The text of an NRRD header with its blank line; `extra` is lines of further fields.
std::string nrrdHeader(
    const std::string& type,
    const std::string& sizes,
    const std::string& encoding = "raw",
    const std::string& extra = "");

std::string metaHeader(
    const std::string& sizes, const std::string& extra = "", const std::string& data = "LOCAL");

struct NiftiOptions {
    std::vector<std::int16_t> dimensions = {4, 4, 4};
    std::int16_t type = 2;
    std::int16_t bits = 8;
    /// Rows of the sform, RAS.
    std::array<float, 12> affine = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    std::array<float, 3> spacing = {1, 1, 1};
    float slope = 0;
    float intercept = 0;
    float offset = 352;
};
/// A NIfTI-1 header and the four bytes after it.
std::string niftiHeader(const NiftiOptions& options);

/// One sample of a field.
float sampleAt(const fields::Field& field, glm::dvec3 point, double radius = 0);

/// Counts the samples at random points of random boxes that the bounds of the box exclude. NaN
/// counts as -infinity. The boxes reach out of `range` by a quarter of its size.
/// @param mostRadius  if above zero, each box has an interval of radii up to that, each point one
///                    of them
std::size_t countExcludedSamples(
    const fields::Field& field,
    const core::Box& range,
    std::size_t boxes,
    std::uint32_t seed,
    double mostRadius = 0);

} // namespace isofront::test
