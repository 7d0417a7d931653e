#pragma once

#include <gtest/gtest.h>

#include <cstdint>

namespace isofront::tests {

/// The types of numbers that files can have.
using SampleTypes = testing::Types<
    std::int8_t,
    std::uint8_t,
    std::int16_t,
    std::uint16_t,
    std::int32_t,
    std::uint32_t,
    std::int64_t,
    std::uint64_t,
    float,
    double>;

/// The types in which voxels are kept.
using VoxelTypes = testing::Types<
    std::int8_t,
    std::uint8_t,
    std::int16_t,
    std::uint16_t,
    std::int32_t,
    std::uint32_t,
    float,
    double>;

} // namespace isofront::tests
