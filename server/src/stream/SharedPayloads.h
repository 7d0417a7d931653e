#pragma once

#include "CellCodec.h"

#include <isofront/extractor/CellMesh.h>

#include <cstddef>
#include <cstdint>
#include <memory>

namespace isofront::server {

/// Payloads of meshes that clients have in common: encoded by whoever asks first, and kept until
/// their bytes exceed a bound, the least recently used let go first. A mesh is known by its place
/// in memory, which surfaces that share cells share.
///
/// Thread: any.
class SharedPayloads {
public:
    explicit SharedPayloads(std::size_t capacityBytes);
    SharedPayloads(const SharedPayloads&) = delete;
    SharedPayloads& operator=(const SharedPayloads&) = delete;
    ~SharedPayloads();

    /// @param mesh  with triangles
    [[nodiscard]] std::shared_ptr<const CellPayload>
    encoded(const std::shared_ptr<const extractor::CellMesh>& mesh);

    struct Stats {
        std::size_t bytes = 0; ///< of what is kept, and of keeping it
        std::uint64_t encoded = 0;
        std::uint64_t shared = 0; ///< asked for and not encoded again
    };
    [[nodiscard]] Stats stats() const;

private:
    class Impl;
    std::unique_ptr<Impl> _impl;
};

} // namespace isofront::server
