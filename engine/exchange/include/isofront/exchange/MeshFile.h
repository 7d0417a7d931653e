#pragma once

#include <isofront/core/Result.h>
#include <isofront/surface/TriangleMesh.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace isofront::exchange {

enum class MeshFormat {
    glb, ///< binary glTF 2.0: float positions relative to a node translation
    ply, ///< binary little-endian PLY: double positions, so nothing is lost
    obj, ///< Wavefront OBJ text, numbers with up to 17 digits, so nothing is lost
    stl, ///< binary STL: float positions in world space, no shared vertices
};

/// The format that a file name's extension asks for, in any case; otherwise a `usage` failure that
/// names the four.
core::Result<MeshFormat> meshFormatOf(const std::filesystem::path& path);

struct ExportOptions {
    /// The program that made the file, as it is named inside it.
    std::string generator = "Isofront";
    /// The mesh's name, where the format has one.
    std::string name = "isosurface";
    /// How the mesh was made, as key and value: extras of the glTF asset, comments in PLY and OBJ.
    std::vector<std::pair<std::string, std::string>> settings;
};

struct ExportReport {
    std::uint64_t bytes = 0; ///< length of the file
    /// The furthest that a coordinate in the file is from the mesh's own, on any axis [world].
    double positionError = 0;
    /// What somebody should know who uses the file: one sentence each.
    std::vector<std::string> warnings;
};

/// Writes a mesh in the format of the path's extension, whole or not at all (see OutputFile). World
/// coordinates stay as they are: nothing is rotated or scaled.
///
/// Attributes go to PLY as the property `attribute`, and to glTF as `_ATTRIBUTE`: four bytes, the
/// lowest first. OBJ and STL have no place for them, which a warning says.
///
/// A mesh without triangles gives a valid file and a warning. Normals are optional (none at all);
/// one that is not of unit length is made so, because readers reject it.
///
/// Fails with `usage` for an unknown extension, `badData` for a mesh that no file can hold
/// (indices past the vertices, coordinates that are not finite or too large for the format's
/// floats), `resourceLimit` for one that is too large for the format, `inputOutput` for the disk.
/// Memory: constant, but for the mesh. Thread: any.
core::Result<ExportReport> writeMesh(
    const surface::TriangleMesh& mesh,
    const std::filesystem::path& path,
    const ExportOptions& options = {});

} // namespace isofront::exchange
