#include "Arguments.h"

#include "Console.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <string_view>
#include <system_error>

namespace isofront::cli {

namespace {

template <typename Number>
bool parseNumber(std::string_view text, Number& number)
{
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    return error == std::errc() && end == text.data() + text.size();
}

} // namespace

CLI::Validator within(double low, double high)
{
    const std::string range = "[" + brief(low) + " - " + brief(high) + "]";
    return {
        [low, high, range](const std::string& text) {
            double number = 0;
            if (CLI::detail::lexical_cast(text, number) && number >= low && number <= high)
                return std::string();
            return "'" + text + "' is not a number in " + range;
        },
        range};
}

CLI::Validator isovalues()
{
    const double largest = double(std::numeric_limits<float>::max()) / 4;
    return within(-largest, largest);
}

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

core::Result<void> checkFolderOf(const std::string& file)
{
    const std::filesystem::path path(file);
    std::error_code ignored;
    if (std::filesystem::is_directory(path, ignored))
        return core::failure(
            core::ErrorCode::inputOutput, file + " is a folder: name a file to write");
    const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
    if (!std::filesystem::is_directory(folder, ignored))
        return core::failure(
            core::ErrorCode::inputOutput,
            file + ": the folder " + folder.string() + " isn't there; make it or choose another");
    return {};
}

void addSamples(CLI::App& command, int& samples)
{
    command
        .add_option(
            "--msaa", samples, "samples of each pixel, for smooth outlines: 1, 4 or 8; 1: softened")
        ->check(CLI::IsMember({1, 4, 8}))
        ->capture_default_str();
}

core::Result<void> checkPixelError(double pixels)
{
    if (pixels > 0 && std::isfinite(pixels))
        return {};
    return core::failure(
        core::ErrorCode::usage, "--pixel-error must be a positive number of pixels");
}

core::Result<void> checkOptions(
    const CLI::App& command, std::initializer_list<std::string_view> ok, const std::string& what)
{
    for (const CLI::Option* option : command.get_options()) {
        const std::string name = option->get_name();
        if (option->count() > 0 && name.starts_with("--") &&
            std::ranges::find(ok, name) == ok.end())
            return core::failure(
                core::ErrorCode::usage, name + " changes nothing for " + what + ": leave it out");
    }
    return {};
}

core::Result<void> checkNoOptions(
    const CLI::App& command, std::initializer_list<std::string_view> wrong, const std::string& what)
{
    for (const std::string_view name : wrong)
        if (command.count(std::string(name)) > 0)
            return core::failure(
                core::ErrorCode::usage,
                std::string(name) + " changes nothing for " + what + ": leave it out");
    return {};
}

core::Error
withOption(const core::Error& error, const std::string& option, const std::string& value)
{
    if (error.code != core::ErrorCode::resourceLimit ||
        error.message.find(option) != std::string::npos)
        return error;
    return {error.code, error.message + " (" + option + " is " + value + ")"};
}

std::optional<std::vector<double>> parseNumbers(std::string_view text, std::size_t count)
{
    std::vector<double> numbers;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        double number = 0;
        if (!parseNumber(text.substr(begin, end - begin), number) || !std::isfinite(number))
            return std::nullopt;
        numbers.push_back(number);
        begin = end + 1;
    }
    return numbers.size() == count ? std::optional(numbers) : std::nullopt;
}

core::Result<glm::dvec3> parsePoint(const std::string& text, const char* option)
{
    const auto numbers = parseNumbers(text, 3);
    if (!numbers)
        return core::failure(
            core::ErrorCode::usage,
            std::string(option) + " '" + text + "': give three numbers, as in 10,-2.5,300");
    return glm::dvec3((*numbers)[0], (*numbers)[1], (*numbers)[2]);
}

} // namespace isofront::cli
