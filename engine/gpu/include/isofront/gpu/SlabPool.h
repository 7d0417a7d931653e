#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

namespace isofront::gpu {

/// Divides a pool of equal slabs into ranges. Knows nothing of what lies there.
///
/// A range up to the size of a slab lies within one slab, together with others; a larger one takes
/// a run of whole slabs for itself. A slab whose ranges are all released is free again, whatever it
/// was used for before, so that the pool can't fragment below the size of a slab. Copyable, so that
/// a failed attempt can be undone.
///
/// Cost: allocate and release O(log slabs + free gaps of one slab).
/// Thread: one at a time.
class SlabPool {
public:
    struct Range {
        std::uint32_t first = 0; ///< [units, from the start of the pool]
        std::uint32_t count = 0; ///< [units]; 0: no range
        bool operator==(const Range&) const = default;
    };

    /// @param slabs, slabUnits  each at least 1, their product below 2^32 (asserted)
    SlabPool(std::uint32_t slabs, std::uint32_t slabUnits);

    /// Finds room in the fullest slab that has it, so that sparse ones drain; nothing if there is
    /// none. A range of 0 units always succeeds and needs no release.
    std::optional<Range> allocate(std::uint32_t units);
    /// Gives back a range exactly as it was allocated (asserted where that can be seen).
    void release(Range range);

    [[nodiscard]] std::uint32_t slabUnits() const { return _slabUnits; }
    [[nodiscard]] std::uint32_t slabs() const { return static_cast<std::uint32_t>(_slabs.size()); }
    [[nodiscard]] std::uint32_t capacity() const { return slabs() * _slabUnits; }
    /// Units that are handed out; a run counts with the unused tail of its last slab.
    [[nodiscard]] std::uint32_t used() const { return _used; }
    [[nodiscard]] std::uint32_t freeSlabs() const { return _freeSlabs; }
    /// Units of one slab that are handed out.
    [[nodiscard]] std::uint32_t usedIn(std::uint32_t slab) const { return _slabs[slab].used; }

    /// The shared slab with the least in it, if that is at most `limit` units and not nothing: its
    /// ranges are worth moving elsewhere.
    [[nodiscard]] std::optional<std::uint32_t> sparsest(std::uint32_t limit) const;
    /// Takes a shared slab out of `allocate` until all its ranges are released.
    void drain(std::uint32_t slab);

private:
    struct Gap {
        std::uint32_t first = 0; ///< within the slab
        std::uint32_t count = 0;
    };
    struct Slab {
        std::uint32_t used = 0;
        bool isRun = false;
        bool isDraining = false;
        std::vector<Gap> gaps; ///< in order, never touching; of a shared slab
    };

    [[nodiscard]] static std::uint32_t largestGap(const Slab& slab);
    /// Takes the first `slabs` of the first free run that is long enough.
    std::optional<std::uint32_t> takeFree(std::uint32_t slabs);
    void giveFree(std::uint32_t first, std::uint32_t slabs);
    void takeFromOpen(std::uint32_t slab);
    void putIntoOpen(std::uint32_t slab);

    std::uint32_t _slabUnits;
    std::uint32_t _used = 0;
    std::uint32_t _freeSlabs;
    std::vector<Slab> _slabs;
    std::map<std::uint32_t, std::uint32_t> _freeRuns; ///< first slab -> how many
    /// Shared slabs with room: (largest gap, slab).
    std::set<std::pair<std::uint32_t, std::uint32_t>> _open;
};

} // namespace isofront::gpu
