#pragma once

#include <isofront/core/Result.h>
#include <isofront/extractor/CellMesh.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace isofront::server {

/// A cell as it is sent: docs/protocol.md, "Payloads".
struct CellPayload {
    std::uint64_t hash = 0; ///< of the bytes: what the client knows them by
    std::vector<std::byte> bytes;
};

/// The largest angle between a normal and what is sent of it [degrees].
inline constexpr double kNormalDegrees = 1.0;

/// Makes a mesh into bytes: positions as they are, normals in two bytes, triangles in an order that
/// suits both the codec and graphics hardware. The same mesh gives the same bytes.
///
/// Source: A. Kapoulkine, meshoptimizer 0.18: index codec version 1, vertex codec version 0.
/// @param mesh  with triangles
CellPayload encodeCell(const extractor::CellMesh& mesh);

/// Reads it back, whatever the bytes are: flags and statistics are not sent, normals and the order
/// of vertices and triangles are not those of the mesh that was encoded.
/// Errors: badData.
core::Result<extractor::CellMesh> decodeCell(std::span<const std::byte> bytes);

/// The name of bytes.
std::uint64_t hashOf(std::span<const std::byte> bytes);

} // namespace isofront::server
