#pragma once

#include "../peers/FlyingEdges.h"

namespace isofront::bench {

/// The functions of a peer's module; null where it was not built.
struct FlyingEdgesModule {
    peers::FlyingEdgesTime time = nullptr;
    peers::FlyingEdgesMesh mesh = nullptr;
    peers::VtkVersion version = nullptr;
};

/// Loads VTK's flying edges from beside the program, on the first call.
const FlyingEdgesModule& flyingEdgesModule();

} // namespace isofront::bench
