#include "DenseVoxels.h"

#include <algorithm>
#include <limits>
#include <type_traits>

namespace isofront::volume {

namespace {

template <std::size_t Index = 0>
VoxelArray allocated(VoxelType type, std::size_t count)
{
    if constexpr (Index < std::variant_size_v<VoxelArray>) {
        if (static_cast<std::size_t>(type) == Index) {
            using Array = std::variant_alternative_t<Index, VoxelArray>;
            return std::make_shared_for_overwrite<typename Array::element_type[]>(count);
        }
        return allocated<Index + 1>(type, count);
    } else {
        return {}; // no such type
    }
}

template <typename To, typename From>
std::shared_ptr<To[]> converted(const From* values, std::size_t count)
{
    auto result = std::make_shared_for_overwrite<To[]>(count);
    std::transform(values, values + count, result.get(), [](From v) { return static_cast<To>(v); });
    return result;
}

template <typename Narrow, typename Wide>
VoxelArray narrowedTo(const Wide* values, std::size_t count, std::vector<std::string>& notes)
{
    if (std::all_of(values, values + count, [](Wide v) {
            return v >= std::numeric_limits<Narrow>::lowest() &&
                   v <= std::numeric_limits<Narrow>::max();
        })) {
        notes.push_back("The file's 64-bit integers all fit 32 bits and are kept in them.");
        return converted<Narrow>(values, count);
    }
    // Beyond 2^62 the way back could overflow; there a double keeps what is a multiple of 2^11.
    constexpr Wide kMost = Wide{1} << 62U;
    const auto isExact = [](Wide v) {
        return v < kMost && static_cast<Wide>(static_cast<double>(v)) == v;
    };
    const bool exact = std::all_of(values, values + count, isExact);
    notes.push_back(
        exact ? "The file's 64-bit integers are kept as doubles, each of them exact."
              : "The file's 64-bit integers are kept as doubles; those beyond 2^53 are rounded.");
    return converted<double>(values, count);
}

} // namespace

VoxelArray allocatedVoxels(VoxelType type, std::size_t count)
{
    return allocated(type, count);
}

VoxelArray narrowed(const std::int64_t* values, std::size_t count, std::vector<std::string>& notes)
{
    return narrowedTo<std::int32_t>(values, count, notes);
}

VoxelArray narrowed(const std::uint64_t* values, std::size_t count, std::vector<std::string>& notes)
{
    return narrowedTo<std::uint32_t>(values, count, notes);
}

} // namespace isofront::volume
