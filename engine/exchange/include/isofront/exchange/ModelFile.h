#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <filesystem>

namespace isofront::exchange {

/// Reads a mesh: PLY (text, or binary of either byte order), STL (text or binary) or OBJ, by its
/// extension, and gzipped or not. Polygons become fans of triangles; colours of vertices are kept;
/// normals, materials and everything else are passed over. Corners of STL that lie at equal places
/// become one.
///
/// Fails with `usage` for another extension, `inputOutput` if the file can't be read, `badData` if
/// it is damaged, each in a sentence that names the file, and the line where it is text. Indices
/// past the vertices are kept: voxels::inspect counts them. Thread: any.
core::Result<voxels::TriangleModel> readModel(const std::filesystem::path& path);

} // namespace isofront::exchange
