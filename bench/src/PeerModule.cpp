#include "PeerModule.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

namespace isofront::bench {

namespace {

/// Opens a module beside the program, for as long as that runs; null where there is none.
void* opened(const char* name)
{
    std::error_code error;
    const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
    const auto path = program.parent_path() / name;
    return ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
}

template <typename Function>
Function functionOf(void* library, const char* name)
{
    return reinterpret_cast<Function>(::dlsym(library, name));
}

} // namespace

const FlyingEdgesModule& flyingEdgesModule()
{
    static const FlyingEdgesModule module = [] {
        FlyingEdgesModule found;
        void* const library = opened("isofront_peer_vtk.so");
        if (library == nullptr)
            return found;
        found.time = functionOf<peers::FlyingEdgesTime>(library, "isofrontFlyingEdgesTime");
        found.mesh = functionOf<peers::FlyingEdgesMesh>(library, "isofrontFlyingEdgesMesh");
        found.version = functionOf<peers::VtkVersion>(library, "isofrontVtkVersion");
        return found;
    }();
    return module;
}

const VolumeToMeshModule& volumeToMeshModule()
{
    static const VolumeToMeshModule module = [] {
        VolumeToMeshModule found;
        void* const library = opened("isofront_peer_openvdb.so");
        if (library == nullptr)
            return found;
        found.mesh = functionOf<peers::VolumeToMesh>(library, "isofrontVolumeToMesh");
        found.voxelize = functionOf<peers::MeshToVolume>(library, "isofrontMeshToVolume");
        found.version = functionOf<peers::OpenVdbVersion>(library, "isofrontOpenVdbVersion");
        return found;
    }();
    return module;
}

const EmbreeModule& embreeModule()
{
    static const EmbreeModule module = [] {
        EmbreeModule found;
        void* const library = opened("isofront_peer_embree.so");
        if (library == nullptr)
            return found;
        found.scene = functionOf<peers::EmbreeScene>(library, "isofrontEmbreeScene");
        found.cast = functionOf<peers::EmbreeCast>(library, "isofrontEmbreeCast");
        found.castPackets = functionOf<peers::EmbreeCast>(library, "isofrontEmbreeCastPackets");
        found.memory = functionOf<peers::EmbreeMemory>(library, "isofrontEmbreeMemory");
        found.close = functionOf<peers::EmbreeClose>(library, "isofrontEmbreeClose");
        return found;
    }();
    return module;
}

} // namespace isofront::bench
