#include "report/Popping.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace isofront::cli {

namespace {

constexpr int kSquare = 8; // [px]

} // namespace

Popping poppingBetween(const core::Image& before, const core::Image& after)
{
    Popping popping;
    std::size_t squares = 0;
    for (int top = 0; top < before.height; top += kSquare) {
        for (int left = 0; left < before.width; left += kSquare) {
            const int bottom = std::min(top + kSquare, before.height);
            const int right = std::min(left + kSquare, before.width);
            std::array<int, 3> sums{};
            for (int y = top; y < bottom; ++y) {
                for (int x = left; x < right; ++x) {
                    for (std::size_t channel = 0; channel < sums.size(); ++channel)
                        sums[channel] +=
                            int{after.pixel(x, y)[channel]} - int{before.pixel(x, y)[channel]};
                }
            }
            const int most = std::max({std::abs(sums[0]), std::abs(sums[1]), std::abs(sums[2])});
            const double change = double(most) / ((bottom - top) * (right - left));
            popping.largest = std::max(popping.largest, change);
            popping.mean += change;
            ++squares;
        }
    }
    if (squares > 0)
        popping.mean /= static_cast<double>(squares);
    return popping;
}

} // namespace isofront::cli
