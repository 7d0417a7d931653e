#pragma once

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/CellId.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace isofront::surface {

/// Meshes of cells that several surfaces of one field in one domain have in common: each is
/// extracted once, whoever asks first, and kept until its bytes exceed a bound, the least recently
/// used let go first. Since extraction is a pure function, who shares and who doesn't see the same.
///
/// Thread: any.
class SharedCells {
public:
    explicit SharedCells(std::size_t capacityBytes);
    SharedCells(const SharedCells&) = delete;
    SharedCells& operator=(const SharedCells&) = delete;
    ~SharedCells();

    /// The mesh of a cell, as the extractor makes it. While another thread extracts the same, waits
    /// for it instead of doing it again.
    /// @param cancelled  looked at between the steps of an extraction
    /// @return null if cancelled
    [[nodiscard]] std::shared_ptr<const extractor::CellMesh> extract(
        const extractor::CellExtractor& extractor,
        const hierarchy::CellId& id,
        const std::atomic<bool>* cancelled = nullptr);

    /// Lets go of the least recently used until the rest fits.
    void setCapacity(std::size_t bytes);

    struct Stats {
        std::size_t bytes = 0; ///< of the meshes kept here, and of keeping them
        std::size_t cells = 0; ///< kept here
        /// Of the meshes from here that somebody has, those kept here included, each counted once.
        std::size_t liveBytes = 0;
        std::uint64_t extracted = 0;
        std::uint64_t shared = 0; ///< asked for and not extracted again
    };
    [[nodiscard]] Stats stats() const;

private:
    class Impl;
    std::unique_ptr<Impl> _impl;
};

/// The mesh of a cell, from what is shared if there is such a thing; null if cancelled.
std::shared_ptr<const extractor::CellMesh> extractShared(
    const extractor::CellExtractor& extractor,
    SharedCells* shared,
    const hierarchy::CellId& id,
    const std::atomic<bool>* cancelled = nullptr);

} // namespace isofront::surface
