#include <isofront/server/Settings.h>

#include <fstream>
#include <iterator>
#include <map>
#include <optional>

namespace isofront::server {
namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view trimmed(std::string_view text)
{
    const std::size_t first = std::min(text.find_first_not_of(kBlanks), text.size());
    return text.substr(first, text.find_last_not_of(kBlanks) + 1 - first);
}

/// The right side of a line, read from its front on.
class Value {
public:
    explicit Value(std::string_view text) : _text(trimmed(text)) {}

    /// All of it, the items of a list joined by commas.
    core::Result<std::string> read()
    {
        auto value = _text.starts_with('[') ? list() : item("#");
        if (!value)
            return value;
        skipBlanks();
        if (!_text.empty() && !_text.starts_with('#'))
            return wrong("'" + std::string(_text) + "' follows the value");
        return value;
    }

private:
    static core::Result<std::string> wrong(const std::string& why)
    {
        return core::failure(core::ErrorCode::usage, why);
    }

    void skipBlanks()
    {
        _text.remove_prefix(std::min(_text.find_first_not_of(kBlanks), _text.size()));
    }

    core::Result<std::string> list()
    {
        std::string items;
        _text.remove_prefix(1);
        for (skipBlanks(); !_text.starts_with(']'); skipBlanks()) {
            auto one = item(",]#");
            if (!one)
                return one;
            items += (items.empty() ? "" : ",") + *one;
            skipBlanks();
            if (_text.starts_with(','))
                _text.remove_prefix(1);
            else if (!_text.starts_with(']'))
                return wrong("the list has no ']' on its line");
        }
        _text.remove_prefix(1);
        return items;
    }

    /// @param ends  what ends an item that isn't in quotes
    core::Result<std::string> item(std::string_view ends)
    {
        if (_text.starts_with('"') || _text.starts_with('\''))
            return quoted();
        const std::size_t end = std::min(_text.find_first_of(ends), _text.size());
        std::string plain(trimmed(_text.substr(0, end)));
        _text.remove_prefix(end);
        if (plain.empty())
            return wrong("there is no value: write \"\" for an empty one");
        return plain;
    }

    core::Result<std::string> quoted()
    {
        const char quote = _text.front();
        std::string text;
        for (std::size_t i = 1; i < _text.size(); ++i) {
            if (_text[i] == quote) {
                _text.remove_prefix(i + 1);
                return text;
            }
            if (quote == '"' && _text[i] == '\\') {
                ++i;
                if (i == _text.size() || (_text[i] != '"' && _text[i] != '\\'))
                    return wrong("of what begins with \\, there are \\\\ and \\\"");
            }
            text += _text[i];
        }
        return wrong("the quotation has no end");
    }

    std::string_view _text;
};

} // namespace

std::string quotedSetting(std::string_view value)
{
    std::string text = "\"";
    for (const char c : value)
        text += (c == '"' || c == '\\' ? "\\" : "") + std::string(1, c);
    return text + "\"";
}

core::Result<std::vector<GivenSetting>>
parseSettings(std::string_view text, const std::string& file)
{
    std::vector<GivenSetting> given;
    std::map<std::string, std::size_t> lines;
    std::string section;
    for (std::size_t number = 1; !text.empty(); ++number) {
        const std::size_t end = std::min(text.find('\n'), text.size());
        const std::string_view line = trimmed(text.substr(0, end));
        text.remove_prefix(std::min(end + 1, text.size()));
        const std::string where = file + ":" + std::to_string(number);
        if (line.empty() || line.starts_with('#'))
            continue;
        if (line.starts_with('[') && line.ends_with(']')) {
            section = std::string(trimmed(line.substr(1, line.size() - 2))) + ".";
            continue;
        }
        const std::size_t equals = line.find('=');
        const std::string name(trimmed(line.substr(0, std::min(equals, line.size()))));
        if (equals == std::string_view::npos || name.empty())
            return core::failure(
                core::ErrorCode::usage,
                where + ": not of the form 'name = value', as 'port = 8080'");
        auto value = Value(line.substr(equals + 1)).read();
        if (!value)
            return tl::unexpected(value.error().within(where + ": " + name));
        const auto [first, isNew] = lines.emplace(section + name, number);
        if (!isNew)
            return core::failure(
                core::ErrorCode::usage,
                where + ": '" + name + "' is given on line " + std::to_string(first->second) +
                    " already");
        given.push_back({section + name, std::move(*value), where});
    }
    return given;
}

core::Result<std::vector<GivenSetting>> settingsOfFile(const std::filesystem::path& file)
{
    const auto unreadable = [&](const std::string& why) {
        return core::failure(core::ErrorCode::inputOutput, file.string() + ": " + why);
    };
    std::error_code ignored;
    if (std::filesystem::is_directory(file, ignored))
        return unreadable("is a folder, not a file of settings");
    std::ifstream in(file, std::ios::binary);
    if (!in)
        return unreadable("can't be read");
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    if (in.bad())
        return unreadable("can't be read to its end");
    return parseSettings(text, file.string());
}

} // namespace isofront::server
