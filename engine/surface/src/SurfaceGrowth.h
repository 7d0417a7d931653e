#pragma once

#include <isofront/core/Powers.h>
#include <isofront/hierarchy/LatticePoint.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>

namespace isofront::surface {

/// Foretells how many diamonds of a level hold surface from how many do in coarser levels: three
/// levels halve all lengths, so a surface meets four times as many, once they are small enough to
/// tell it from a volume.
class SurfaceGrowth {
public:
    /// One more diamond of that level may hold surface.
    void add(int level) { ++_counts[static_cast<std::size_t>(level)]; }

    /// How many of a level will, about, and rather too few; nothing as long as there is no steady
    /// growth to go by.
    /// @param counted  the last level of which all have been added
    [[nodiscard]] std::optional<double> expectedAt(int level, int counted) const
    {
        if (counted < 6 || level <= counted)
            return std::nullopt;
        const auto at = [&](int which) {
            return static_cast<double>(_counts[static_cast<std::size_t>(which)]);
        };
        if (at(counted - 6) < kFewest)
            return std::nullopt;
        const double growth =
            std::min(at(counted) / at(counted - 3), at(counted - 3) / at(counted - 6));
        if (growth < kSlowest)
            return std::nullopt;
        const double perLevel = core::cubeRoot(std::min(growth, kOfSurface));
        return at(counted) * core::wholePower(perLevel, static_cast<unsigned>(level - counted));
    }

private:
    static constexpr double kFewest = 8;
    static constexpr double kSlowest = 2;
    static constexpr double kOfSurface = 4;

    std::array<std::size_t, hierarchy::kMaxLevel + 1> _counts{};
};

} // namespace isofront::surface
