#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <cstdint>
#include <filesystem>

namespace isofront::exchange {

/// Whether a name ends as those of meshes do that `readModel` reads.
bool isModelName(const std::filesystem::path& path);

/// Reads a mesh: PLY (text, or binary of either byte order), STL (text or binary) or OBJ, by its
/// extension, and gzipped or not. Polygons become fans of triangles; colours of vertices are kept;
/// normals, materials and everything else are passed over. Corners of STL that lie at equal places
/// become one.
///
/// Fails with `usage` for another extension, `inputOutput` if the file can't be read, `badData` if
/// it is damaged, `resourceLimit` if there is more in it than allowed, each in a sentence that
/// names the file, and the line where it is text. Indices past the vertices are kept:
/// voxels::inspect counts them. Thread: any.
///
/// @param mostBytes  of the file, unpacked; the model takes about as much again
core::Result<voxels::TriangleModel>
readModel(const std::filesystem::path& path, std::uint64_t mostBytes = std::uint64_t{1} << 36U);

} // namespace isofront::exchange
