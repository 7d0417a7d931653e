#include "FlyingEdges.h"

#include "PeerModule.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

namespace isofront::bench {

namespace {

/// The voxels again, by sampling the field at their centres, as numbers of so many bytes.
std::vector<std::uint8_t>
voxelsOf(const volume::LoadedVolume& volume, const glm::ivec3& size, std::size_t bytesEach)
{
    std::vector<std::uint8_t> bytes;
    fields::SampleGrid slice;
    slice.count = {size.x, size.y, 1};
    std::vector<float> values(slice.size());
    for (int z = 0; z < size.z; ++z) {
        slice.first = {0, 0, z};
        volume.field->sampleGrid(slice, values);
        for (const float value : values) {
            std::array<std::uint8_t, 4> one{};
            if (bytesEach == 1) {
                one[0] = static_cast<std::uint8_t>(value);
            } else if (bytesEach == 2) {
                const auto whole = static_cast<std::int16_t>(value);
                std::memcpy(one.data(), &whole, sizeof(whole));
            } else {
                std::memcpy(one.data(), &value, sizeof(value));
            }
            bytes.insert(bytes.end(), one.begin(), one.begin() + std::ptrdiff_t(bytesEach));
        }
    }
    return bytes;
}

} // namespace

FlyingEdges::FlyingEdges(const volume::LoadedVolume& volume)
    : _size(volume.dataBox.size() + 1.5),
      _bytesEach(
          volume.info.voxelType == volume::VoxelType::uint8   ? 1
          : volume.info.voxelType == volume::VoxelType::int16 ? 2
                                                              : 4)
{
    if (flyingEdgesModule().time != nullptr)
        _voxels = voxelsOf(volume, _size, _bytesEach);
}

std::optional<FlyingEdgesResult> FlyingEdges::run(double isovalue, std::size_t threads) const
{
    const peers::FlyingEdgesTime time = flyingEdgesModule().time;
    if (time == nullptr)
        return std::nullopt;
    const std::array<int, 3> extent{_size.x, _size.y, _size.z};
    std::array<double, 4> answer{};
    time(
        extent.data(),
        static_cast<int>(_bytesEach),
        _voxels.data(),
        isovalue,
        static_cast<int>(threads),
        answer.data());
    FlyingEdgesResult result;
    result.timing.least = answer[0];
    result.timing.median = answer[0];
    result.timing.wall = answer[1];
    result.timing.runs = 1;
    result.triangles = static_cast<std::size_t>(answer[2]);
    return result;
}

} // namespace isofront::bench
