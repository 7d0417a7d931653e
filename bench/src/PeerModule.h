#pragma once

#include "../peers/EmbreeRays.h"
#include "../peers/FlyingEdges.h"
#include "../peers/MeshToVolume.h"
#include "../peers/VolumeToMesh.h"

namespace isofront::bench {

// The functions of peers' modules; null where they were not built.

struct FlyingEdgesModule {
    peers::FlyingEdgesTime time = nullptr;
    peers::FlyingEdgesMesh mesh = nullptr;
    peers::VtkVersion version = nullptr;
};

struct VolumeToMeshModule {
    peers::VolumeToMesh mesh = nullptr;
    peers::MeshToVolume voxelize = nullptr;
    peers::OpenVdbVersion version = nullptr;
};

struct EmbreeModule {
    peers::EmbreeScene scene = nullptr;
    peers::EmbreeCast cast = nullptr;
    peers::EmbreeCast castPackets = nullptr;
    peers::EmbreeMemory memory = nullptr;
    peers::EmbreeClose close = nullptr;
};

/// Loads VTK's flying edges from beside the program, on the first call.
const FlyingEdgesModule& flyingEdgesModule();
/// The same for OpenVDB's mesher and voxeliser.
const VolumeToMeshModule& volumeToMeshModule();
/// The same for Embree's rays.
const EmbreeModule& embreeModule();

} // namespace isofront::bench
