#include "Arguments.h"

#include <charconv>
#include <cmath>
#include <string_view>

namespace isofront::cli {

namespace {

template <typename Number>
bool parseNumber(std::string_view text, Number& number)
{
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size();
}

} // namespace

core::Result<PictureSize> parseSize(const std::string& text)
{
    PictureSize size;
    const std::size_t cross = text.find('x');
    const std::string_view view = text;
    if (cross == std::string::npos || !parseNumber(view.substr(0, cross), size.width) ||
        !parseNumber(view.substr(cross + 1), size.height) || size.width < 1 || size.height < 1 ||
        size.width > 16384 || size.height > 16384)
        return core::failure(
            core::ErrorCode::usage,
            "--size '" + text + "': give width and height from 1 to 16384 pixels, as in 1280x720");
    return size;
}

core::Result<glm::dvec3> parsePoint(const std::string& text, const char* option)
{
    glm::dvec3 point(0.0);
    const std::string_view view = text;
    std::size_t begin = 0;
    bool good = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t end = axis < 2 ? view.find(',', begin) : view.size();
        good = good && end != std::string_view::npos &&
               parseNumber(view.substr(begin, end - begin), point[axis]) &&
               std::isfinite(point[axis]);
        if (!good)
            return core::failure(
                core::ErrorCode::usage,
                std::string(option) + " '" + text + "': give three numbers, as in 10,-2.5,300");
        begin = end + 1;
    }
    return point;
}

} // namespace isofront::cli
