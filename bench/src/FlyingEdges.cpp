#include "FlyingEdges.h"

#include <dlfcn.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <vector>

namespace isofront::bench {

namespace {

using Run = void (*)(const int*, int, const void*, double, int, int, double*);

/// The peer, which lies beside the program; null if it isn't there.
Run peer()
{
    static const Run found = [] {
        std::error_code error;
        const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
        const auto path = program.parent_path() / "isofront_peer_vtk.so";
        void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
        return library == nullptr ? nullptr
                                  : reinterpret_cast<Run>(::dlsym(library, "isofrontFlyingEdges"));
    }();
    return found;
}

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
    if (peer() != nullptr)
        _voxels = voxelsOf(volume, _size, _bytesEach);
}

std::optional<FlyingEdgesResult> FlyingEdges::run(double isovalue, std::size_t threads) const
{
    if (peer() == nullptr)
        return std::nullopt;
    const std::array<int, 3> extent{_size.x, _size.y, _size.z};
    std::array<double, 4> answer{};
    peer()(
        extent.data(),
        static_cast<int>(_bytesEach),
        _voxels.data(),
        isovalue,
        static_cast<int>(threads),
        1,
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
