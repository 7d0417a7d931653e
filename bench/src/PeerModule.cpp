#include "PeerModule.h"

#include <dlfcn.h>

#include <filesystem>
#include <system_error>

namespace isofront::bench {

const FlyingEdgesModule& flyingEdgesModule()
{
    static const FlyingEdgesModule module = [] {
        std::error_code error;
        const auto program = std::filesystem::read_symlink("/proc/self/exe", error);
        const auto path = program.parent_path() / "isofront_peer_vtk.so";
        FlyingEdgesModule found;
        void* const library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
        if (library == nullptr)
            return found;
        found.time =
            reinterpret_cast<peers::FlyingEdgesTime>(::dlsym(library, "isofrontFlyingEdgesTime"));
        found.mesh =
            reinterpret_cast<peers::FlyingEdgesMesh>(::dlsym(library, "isofrontFlyingEdgesMesh"));
        found.version = reinterpret_cast<peers::VtkVersion>(::dlsym(library, "isofrontVtkVersion"));
        return found;
    }();
    return module;
}

} // namespace isofront::bench
