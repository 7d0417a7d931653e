#include "TextHeader.h"

#include <algorithm>
#include <charconv>

namespace isofront::volume {

namespace {
constexpr std::string_view kBlanks = " \t\r\n";
}

std::string_view trimmed(std::string_view text)
{
    const std::size_t first = text.find_first_not_of(kBlanks);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string lowered(std::string_view text)
{
    std::string result(text);
    for (char& c : result)
        if (c >= 'A' && c <= 'Z')
            c = static_cast<char>(c - 'A' + 'a');
    return result;
}

std::optional<std::string> readLine(std::istream& stream)
{
    constexpr std::size_t kLongest = std::size_t{1} << 16U;
    std::string line;
    for (int c = stream.get(); c != std::istream::traits_type::eof(); c = stream.get()) {
        if (c == '\n')
            return line;
        if (line.size() == kLongest)
            return std::nullopt;
        line.push_back(static_cast<char>(c));
    }
    return line.empty() ? std::nullopt : std::optional(line);
}

core::Result<void> checkLine(std::string_view line)
{
    if (line.ends_with('\r'))
        line.remove_suffix(1);
    const bool isPlain = std::ranges::none_of(
        line, [](char c) { return (c >= 0 && c < 0x20 && c != '\t') || c == 0x7f; });
    if (isPlain)
        return {};
    return core::failure(
        core::ErrorCode::badData,
        "a line of the header has control characters, so that it isn't clear where it ends; write "
        "it as plain text");
}

std::optional<std::int64_t> integerFrom(std::string_view text)
{
    text = trimmed(text);
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

std::optional<std::vector<std::int64_t>> integersFrom(std::string_view text)
{
    std::vector<std::int64_t> values;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const std::size_t length = std::min(text.find_first_of(kBlanks), text.size());
        const auto value = integerFrom(text.substr(0, length));
        if (!value)
            return std::nullopt;
        values.push_back(*value);
        text.remove_prefix(length);
    }
    return values;
}

} // namespace isofront::volume
