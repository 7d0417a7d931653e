// Based on: Wavefront, "Advanced Visualizer Manual", appendix B1, "Object files".

#include "ModelFormats.h"
#include "TextScanner.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace isofront::exchange {

namespace {

core::Error damaged(const std::string& what)
{
    return {core::ErrorCode::badData, what};
}

/// The position that a corner "5/2/7" names, counted from 0; negative ones count from the end.
/// What no position has becomes an index that nothing has. Nothing if it is no number.
std::optional<std::uint32_t> cornerOf(std::string_view word, std::size_t positions)
{
    const auto number = TextScanner::numberOf<std::int64_t>(word.substr(0, word.find('/')));
    if (!number)
        return std::nullopt;
    const std::int64_t index =
        *number < 0 ? static_cast<std::int64_t>(positions) + *number : *number - 1;
    return index >= 0 && index < 0xffffffffLL ? static_cast<std::uint32_t>(index) : 0xffffffffU;
}

} // namespace

core::Result<voxels::TriangleModel> readObj(std::span<const std::byte> bytes)
{
    TextScanner text(bytes);
    voxels::TriangleModel model;
    bool allColoured = true;
    while (text.nextLine()) {
        const std::string_view key = text.word();
        if (key == "v") {
            // x, y, z, and, as many programs write it, red, green and blue
            std::array<double, 6> numbers{};
            std::size_t count = 0;
            for (; count < numbers.size(); ++count) {
                const std::string_view word = text.word();
                if (word.empty())
                    break;
                const auto number = TextScanner::numberOf<double>(word);
                if (!number)
                    return tl::unexpected(damaged(text.at("a vertex has what is no number")));
                numbers[count] = *number;
            }
            if (count < 3)
                return tl::unexpected(damaged(text.at("a vertex needs three numbers")));
            model.positions.emplace_back(numbers[0], numbers[1], numbers[2]);
            allColoured = allColoured && count == 6;
            std::uint32_t colour = 0xff000000U;
            for (unsigned i = 0; i < 3; ++i) {
                const double code = 255 * numbers[3 + i];
                const auto bits =
                    code > 0 ? static_cast<std::uint32_t>(std::lround(std::min(code, 255.0))) : 0;
                colour |= bits << 8 * i;
            }
            model.colours.push_back(colour);
        } else if (key == "f") {
            std::uint32_t first = 0;
            std::uint32_t last = 0;
            for (std::size_t count = 0;; ++count) {
                const std::string_view word = text.word();
                if (word.empty())
                    break;
                const auto corner = cornerOf(word, model.positions.size());
                if (!corner)
                    return tl::unexpected(damaged(text.at("a face has what is no index")));
                if (count == 0)
                    first = *corner;
                else if (count > 1)
                    model.triangles.push_back({first, last, *corner});
                last = *corner;
            }
        }
    }
    if (!allColoured)
        model.colours.clear();
    return model;
}

} // namespace isofront::exchange
