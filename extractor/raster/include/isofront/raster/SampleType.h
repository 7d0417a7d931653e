#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace isofront::raster {

/// The types of numbers that files of samples hold.
enum class SampleType {
    int8,
    uint8,
    int16,
    uint16,
    int32,
    uint32,
    int64,
    uint64,
    float32,
    float64
};

/// "int8", "uint8" ... "float32", "float64".
std::string_view nameOf(SampleType type);
/// Bytes that one sample takes.
std::size_t bytesOf(SampleType type);
/// The type of this name, in lower case; also "float" and "double".
std::optional<SampleType> sampleTypeNamed(std::string_view name);

/// Calls `action` with a zero of the type's C++ type and returns what it returns.
template <typename Action>
auto dispatched(SampleType type, Action&& action)
{
    switch (type) {
    case SampleType::int8:
        return action(std::int8_t{});
    case SampleType::uint8:
        return action(std::uint8_t{});
    case SampleType::int16:
        return action(std::int16_t{});
    case SampleType::uint16:
        return action(std::uint16_t{});
    case SampleType::int32:
        return action(std::int32_t{});
    case SampleType::uint32:
        return action(std::uint32_t{});
    case SampleType::int64:
        return action(std::int64_t{});
    case SampleType::uint64:
        return action(std::uint64_t{});
    case SampleType::float32:
        return action(float{});
    case SampleType::float64:
        break;
    }
    return action(double{});
}

} // namespace isofront::raster
