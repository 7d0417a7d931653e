// Based on: Wavefront, "Advanced Visualizer Manual", appendix B1, "Object files".

#include "ModelBudget.h"
#include "ModelFormats.h"
#include "ObjMaterials.h"
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

constexpr std::uint32_t kNowhere = 0xffffffffU;

/// What a number of many names, counted from 0; negative ones count from the end. What there is
/// none of becomes kNowhere. Nothing if it is no number.
std::optional<std::uint32_t> indexOf(std::string_view word, std::size_t many)
{
    const auto number = TextScanner::numberOf<std::int64_t>(word);
    if (!number)
        return std::nullopt;
    const auto last = static_cast<std::int64_t>(many);
    if (*number < -last)
        return kNowhere;
    const std::int64_t index = *number < 0 ? last + *number : *number - 1;
    return index >= 0 && index < kNowhere ? static_cast<std::uint32_t>(index) : kNowhere;
}

/// A corner "5/2/7": position 5, place 2 in the texture, and a normal.
struct Corner {
    std::uint32_t position = kNowhere;
    std::uint32_t place = kNowhere;
};

std::optional<Corner> cornerOf(std::string_view word, std::size_t positions, std::size_t places)
{
    const std::size_t slash = word.find('/');
    const auto position = indexOf(word.substr(0, slash), positions);
    if (!position)
        return std::nullopt;
    Corner corner{*position, kNowhere};
    if (slash == std::string_view::npos)
        return corner;
    const std::string_view rest = word.substr(slash + 1);
    if (const std::string_view place = rest.substr(0, rest.find('/')); !place.empty()) {
        const auto index = indexOf(place, places);
        if (!index)
            return std::nullopt;
        corner.place = *index;
    }
    return corner;
}

} // namespace

core::Result<voxels::TriangleModel>
readObj(std::span<const std::byte> bytes, const ModelContext& context)
{
    TextScanner text(bytes, Continuation::backslash);
    voxels::TriangleModel model;
    const ModelBudget budget(context.mostBytes);
    ObjMaterials materials(context, model);
    std::uint32_t texture = voxels::kNoTexture;
    std::vector<glm::vec2> places;
    const auto placeOf = [&](const Corner& corner) {
        return corner.place < places.size() ? places[corner.place] : glm::vec2(0);
    };
    const auto overrun = [&] {
        return budget.check(model, {.otherBytes = places.size() * sizeof(glm::vec2)});
    };
    bool allColoured = true;
    while (text.nextLine()) {
        if (auto failed = overrun())
            return tl::unexpected(*failed);
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
        } else if (key == "vt") {
            // from the bottom up; a model has them from the top down
            const auto u = text.number<float>();
            const auto v = text.number<float>();
            if (!u)
                return tl::unexpected(damaged(text.at("a place in a texture needs a number")));
            places.emplace_back(*u, 1 - v.value_or(0.0F));
        } else if (key == "mtllib") {
            materials.readLibrary(text.rest());
        } else if (key == "usemtl") {
            texture = materials.textureOf(text.rest());
        } else if (key == "f") {
            Corner first;
            Corner last;
            for (std::size_t count = 0;; ++count) {
                const std::string_view word = text.word();
                if (word.empty())
                    break;
                const auto corner = cornerOf(word, model.positions.size(), places.size());
                if (!corner)
                    return tl::unexpected(damaged(text.at("a face has what is no index")));
                if (count == 0)
                    first = *corner;
                else if (count > 1) {
                    model.triangles.push_back({first.position, last.position, corner->position});
                    if (!model.textures.empty()) {
                        // those before the first material have none
                        model.textureOf.resize(model.triangles.size() - 1, voxels::kNoTexture);
                        model.textureCorners.resize(model.triangles.size() - 1);
                        model.textureOf.push_back(texture);
                        model.textureCorners.push_back(
                            {placeOf(first), placeOf(last), placeOf(*corner)});
                    }
                    if (auto failed = overrun()) // a line may be as long as the file
                        return tl::unexpected(*failed);
                }
                last = *corner;
            }
        }
    }
    if (auto failed = overrun())
        return tl::unexpected(*failed);
    if (!allColoured)
        model.colours.clear();
    return model;
}

} // namespace isofront::exchange
