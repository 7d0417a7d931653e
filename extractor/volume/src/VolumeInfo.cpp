#include "isofront/volume/VolumeInfo.h"

namespace isofront::volume {

std::string_view nameOf(VoxelType type)
{
    constexpr std::array<std::string_view, 8> kNames = {
        "int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"};
    return kNames[static_cast<std::size_t>(type)];
}

std::size_t bytesOf(VoxelType type)
{
    constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
    return kBytes[static_cast<std::size_t>(type)];
}

std::string_view nameOf(VolumeFormat format)
{
    constexpr std::array<std::string_view, 8> kNames = {
        "NRRD", "NIfTI", "MetaImage", "OpenVDB", "DICOM", "TIFF", "raw", "mesh"};
    return kNames[static_cast<std::size_t>(format)];
}

} // namespace isofront::volume
