#include "isofront/raster/SampleType.h"

#include <array>
#include <utility>

namespace isofront::raster {

namespace {

constexpr std::array<std::pair<std::string_view, std::size_t>, 10> kTypes{
    {{"int8", 1},
     {"uint8", 1},
     {"int16", 2},
     {"uint16", 2},
     {"int32", 4},
     {"uint32", 4},
     {"int64", 8},
     {"uint64", 8},
     {"float32", 4},
     {"float64", 8}}};

} // namespace

std::string_view nameOf(SampleType type)
{
    return kTypes[static_cast<std::size_t>(type)].first;
}

std::size_t bytesOf(SampleType type)
{
    return kTypes[static_cast<std::size_t>(type)].second;
}

std::optional<SampleType> sampleTypeNamed(std::string_view name)
{
    if (name == "float")
        return SampleType::float32;
    if (name == "double")
        return SampleType::float64;
    for (std::size_t i = 0; i < kTypes.size(); ++i)
        if (kTypes[i].first == name)
            return static_cast<SampleType>(i);
    return std::nullopt;
}

} // namespace isofront::raster
