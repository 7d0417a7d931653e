#pragma once

#include "MeshView.h"
#include "isofront/exchange/MeshFile.h"
#include "isofront/exchange/OutputFile.h"

#include <glm/vec3.hpp>

#include <cstdint>

namespace isofront::exchange {

/// What the writer of one format gets: a mesh that was checked, and where its bytes and remarks go.
struct MeshJob {
    const MeshView& mesh;
    const ExportOptions& options;
    OutputFile& file;
    ExportReport& report;
};

/// Each fails only if the format can't hold the mesh; the disk's failures wait in the file.
core::Result<void> writeGlb(const MeshJob& job);
core::Result<void> writePly(const MeshJob& job);
core::Result<void> writeObj(const MeshJob& job);
core::Result<void> writeStl(const MeshJob& job);

/// The node translation of a glTF file: near the centre of the bounds, on a grid of a power of two
/// that is no coarser than a sixteenth of the bounds unless float needs it coarser. It is exact in
/// float, so that a reader loses nothing that takes translations as float, and local coordinates
/// stay small.
glm::dvec3 glbTranslation(const core::Box& bounds);

/// The length of the binary part of a glTF file [bytes].
std::uint64_t glbBinaryBytes(
    std::uint64_t vertices, std::uint64_t triangles, bool normals, bool attributes = false);

/// The text in one line, for formats whose comments end with it.
std::string inOneLine(std::string text);

} // namespace isofront::exchange
