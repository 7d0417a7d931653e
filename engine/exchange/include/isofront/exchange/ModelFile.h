#pragma once

#include <isofront/core/Result.h>
#include <isofront/voxels/TriangleModel.h>

#include <cstdint>
#include <filesystem>

namespace isofront::exchange {

/// Whether a name ends as those of meshes do that `readModel` reads.
bool isModelName(const std::filesystem::path& path);

/// Whether files that a mesh names are read. Files of strangers should not: they would have
/// anything read that the process may.
enum class OtherFiles : bool { ignore, read };

/// Reads a mesh: glTF (text or binary), PLY (text, or binary of either byte order), OBJ or STL
/// (text or binary), by its extension, and gzipped or not.
///
/// Polygons become fans of triangles, strips and fans triangles of their own; the default scene of
/// glTF is put together, with its nodes' transforms, and skinned as it stands before animations.
/// Colours of vertices are kept, and PNG and JPEG textures of base colours, with their factors; of
/// OBJ materials the picture, or the colour where there is none. Normals and everything else are
/// passed over; what is missed is told in TriangleModel::notes. Corners of STL that lie at equal
/// places become one. Buffers, pictures and materials in other files are read from beside the file;
/// if they are to be ignored, a mesh whose buffers lie elsewhere fails with `badData`.
///
/// Fails with `usage` for another extension, `inputOutput` if the file can't be read, `badData` if
/// it is damaged, `resourceLimit` if there is more in it than allowed, each in a sentence that
/// names the file, and the line where it is text. Indices past the vertices are kept:
/// voxels::inspect counts them. Thread: any.
///
/// @param mostBytes  of the file, unpacked, and of each that it names; of a picture's pixels, and
/// of
///                   the model
core::Result<voxels::TriangleModel> readModel(
    const std::filesystem::path& path,
    std::uint64_t mostBytes = std::uint64_t{1} << 36U,
    OtherFiles otherFiles = OtherFiles::read);

} // namespace isofront::exchange
