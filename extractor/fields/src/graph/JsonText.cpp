#include "graph/JsonText.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <set>
#include <utility>
#include <vector>

namespace isofront::fields::graph {

namespace {

constexpr std::size_t kDeepestBrackets = 100;

/// Walks along a text and lets others see how far it has come.
class Cursor {
public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    Cursor(const char* at, const char** seen) : _at(at), _seen(seen) {}

    reference operator*() const { return *_at; }
    Cursor& operator++()
    {
        *_seen = ++_at;
        return *this;
    }
    Cursor operator++(int)
    {
        Cursor before = *this;
        ++*this;
        return before;
    }
    bool operator==(const Cursor& other) const { return _at == other._at; }

private:
    const char* _at;
    const char** _seen;
};

/// Follows a parser from token to token; so it knows what may come next.
class Watcher final : public nlohmann::json_sax<Json> {
public:
    explicit Watcher(std::string_view text) : _text(text), _seen(text.data()) {}

    [[nodiscard]] Cursor begin() { return {_text.data(), &_seen}; }
    [[nodiscard]] Cursor end() { return {_text.data() + _text.size(), &_seen}; }

    bool null() override { return value(); }
    bool boolean(bool /*unused*/) override { return value(); }
    bool number_integer(std::int64_t /*unused*/) override { return number(); }
    bool number_unsigned(std::uint64_t /*unused*/) override { return number(); }
    bool number_float(double /*unused*/, const std::string& /*unused*/) override
    {
        return number();
    }
    bool string(std::string& /*unused*/) override { return value(); }
    bool binary(Json::binary_t& /*unused*/) override { return value(); }

    bool start_object(std::size_t /*unused*/) override { return open(Before::firstKey); }
    bool end_object() override { return close(); }
    bool start_array(std::size_t /*unused*/) override { return open(Before::firstElement); }
    bool end_array() override { return close(); }

    bool key(std::string& name) override
    {
        Bracket& bracket = _brackets.back();
        if (!bracket.keys.insert(name).second)
            fail(nextToken().begin, "the key " + inQuotes(name) + " is there twice; remove one");
        bracket.key = name;
        bracket.next = Before::memberValue;
        _behind = consumed();
        return true;
    }

    bool parse_error(
        std::size_t position,
        const std::string& /*lastToken*/,
        const nlohmann::detail::exception& error) override
    {
        constexpr int kTooLarge = 406; // the library's number of the error
        const Token token = nextToken();
        const std::string shown = inQuotes(token.text);
        if (token.text.empty())
            fail(_text.size(), "the text ends, where " + expected(token) + " should follow");
        if (error.id == kTooLarge)
            fail(token.begin, "the number " + shown + " is too large to be one");
        const bool isText = token.text.front() == '"';
        const bool isEnded = token.text.size() > 1 && token.text.back() == '"' &&
                             position >= token.begin + token.text.size();
        if (isText && !isEnded)
            fail(
                std::min(position - 1, _text.size()),
                "this can't be within a text; it ends on its line, has two backslashes for one, "
                "and "
                "is written in UTF-8");
        fail(token.begin, shown + " stands where " + expected(token) + " should" + hint(token));
    }

private:
    /// What the parser looks for, in the innermost bracket.
    enum class Before { firstKey, memberValue, nextMember, firstElement, nextElement };

    struct Bracket {
        Before next;
        std::set<std::string> keys = {};
        std::string key = {};
    };

    /// What comes behind the last thing that was read.
    struct Token {
        std::size_t begin;      ///< in the text
        std::string_view text;  ///< empty at the end
        bool isBehindSeparator; ///< the comma or colon that has to come first is there
    };
    [[nodiscard]] Token nextToken() const
    {
        constexpr std::string_view kSpace = " \t\r\n";
        const auto skipped = [&](std::size_t at) {
            return std::min(_text.find_first_not_of(kSpace, at), _text.size());
        };
        constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
        const bool isMarked = _behind == 0 && _text.starts_with(kByteOrderMark);
        std::size_t begin = skipped(isMarked ? kByteOrderMark.size() : _behind);
        const Before next = _brackets.empty() ? Before::firstElement : _brackets.back().next;
        const char separator = next == Before::memberValue                                 ? ':'
                               : next == Before::nextMember || next == Before::nextElement ? ','
                                                                                           : '\0';
        const bool isThere = separator != '\0' && begin < _text.size() && _text[begin] == separator;
        if (isThere)
            begin = skipped(begin + 1);
        const std::string_view rest = _text.substr(begin);
        std::size_t length = rest.empty() ? 0 : 1;
        if (rest.starts_with('"')) {
            while (length < rest.size() && rest[length] != '"' && rest[length] != '\n')
                length += rest[length] == '\\' ? 2U : 1U;
            length += length < rest.size() && rest[length] == '"' ? 1U : 0U;
            length = std::min(length, rest.size());
        } else if (!rest.empty() && std::string_view("{}[],:").find(rest[0]) == rest.npos) {
            length = std::min(rest.find_first_of(" \t\r\n{}[],:\""), rest.size());
        }
        return {begin, rest.substr(0, length), isThere};
    }

    /// The parser has looked one byte too far to see where a number ends.
    bool number()
    {
        const Token token = nextToken();
        std::size_t length = 0;
        const auto digits = [&] {
            while (length < token.text.size() && token.text[length] >= '0' &&
                   token.text[length] <= '9')
                ++length;
        };
        const auto oneOf = [&](std::string_view characters) {
            const bool isThere = length < token.text.size() &&
                                 characters.find(token.text[length]) != characters.npos;
            length += isThere ? 1U : 0U;
            return isThere;
        };
        oneOf("-");
        if (!oneOf("0"))
            digits();
        if (oneOf("."))
            digits();
        if (oneOf("eE")) {
            oneOf("+-");
            digits();
        }
        value();
        _behind = token.begin + length;
        return true;
    }
    bool value()
    {
        _behind = consumed();
        if (_brackets.empty()) {
            _isOver = true;
            return true;
        }
        Before& next = _brackets.back().next;
        next = next == Before::memberValue ? Before::nextMember : Before::nextElement;
        return true;
    }
    bool open(Before next)
    {
        if (_brackets.size() == kDeepestBrackets)
            fail(
                nextToken().begin,
                "brackets are nested deeper than " + std::to_string(kDeepestBrackets) +
                    "; give inner nodes names of their own");
        _brackets.push_back({next});
        _behind = consumed();
        return true;
    }
    bool close()
    {
        _brackets.pop_back();
        return value();
    }

    [[nodiscard]] std::string expected(const Token& token) const
    {
        if (_brackets.empty())
            return _isOver ? "nothing more" : "a preset, in braces,";
        const Bracket& bracket = _brackets.back();
        const bool isBehind = token.isBehindSeparator;
        switch (bracket.next) {
        case Before::firstKey:
            return "a name in double quotes, or '}',";
        case Before::memberValue:
            return (isBehind ? "a value for " : "a colon and a value for ") + inQuotes(bracket.key);
        case Before::nextMember:
            return isBehind ? "a name in double quotes" : "a comma and a name, or '}',";
        case Before::firstElement:
            return "a value, or ']',";
        case Before::nextElement:
            break;
        }
        return isBehind ? "a value" : "a comma and a value, or ']',";
    }

    /// What one may not know of JSON.
    [[nodiscard]] static std::string hint(const Token& token)
    {
        const char first = token.text.front();
        if ((first == '}' || first == ']') && token.isBehindSeparator)
            return "; remove the comma before it";
        if (first == '/' || first == '#')
            return "; JSON has no comments";
        if (first == '\'')
            return "; texts have double quotes";
        if (std::string_view("+-.0123456789").find(first) != std::string_view::npos ||
            token.text == "NaN" || token.text == "Infinity")
            return "; numbers are written as 0.5, -2 or 1e-3";
        if ((first >= 'a' && first <= 'z') || (first >= 'A' && first <= 'Z'))
            return "; words but true and false have double quotes";
        return "";
    }

    [[nodiscard]] std::size_t consumed() const
    {
        return static_cast<std::size_t>(_seen - _text.data());
    }

    /// @param at  byte of the text
    [[noreturn]] void fail(std::size_t at, const std::string& why) const
    {
        const std::string_view before = _text.substr(0, at);
        const auto line = 1 + std::count(before.begin(), before.end(), '\n');
        const std::size_t lineBegin = before.rfind('\n') + 1; // 0 if there is none
        throw Problem{
            "line " + std::to_string(line) + ", column " +
            std::to_string(before.size() - lineBegin + 1) + ": " + why};
    }

    std::string_view _text;
    const char* _seen;
    std::size_t _behind = 0; ///< what has been understood ends here
    std::vector<Bracket> _brackets;
    bool _isOver = false;
};

/// How many letters have to be changed, added or left out to make one word of the other.
std::size_t slipsBetween(std::string_view a, std::string_view b)
{
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i);
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t changed = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
        }
    }
    return row[b.size()];
}

} // namespace

Json parsedJson(std::string_view text)
{
    if (text.size() > kMostBytes)
        throw Problem{"it is longer than 1 MiB; a preset is a few kilobytes"};
    Watcher watcher(text);
    Json::sax_parse(watcher.begin(), watcher.end(), &watcher);
    return Json::parse(text);
}

std::string inQuotes(std::string_view text, std::size_t most)
{
    const bool isLong = text.size() > most;
    std::size_t end = isLong ? most : text.size();
    // Not in the middle of a letter of several bytes.
    while (isLong && end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U)
        --end;
    std::string shown = "'";
    for (const char c : text.substr(0, end)) {
        const auto code = static_cast<unsigned char>(c);
        shown += code < 0x20U || code == 0x7FU ? '?' : c;
    }
    return shown + (isLong ? "...'" : "'");
}

std::string suggestion(std::string_view word, std::span<const std::string> words)
{
    constexpr std::size_t kLongestWord = 30;
    const std::string* nearest = nullptr;
    // Of a short word nothing would be left.
    std::size_t most = std::min<std::size_t>(2, word.size() / 3) + 1;
    for (const std::string& candidate : words) {
        if (std::max(word.size(), candidate.size()) > kLongestWord)
            continue;
        const std::size_t slips = slipsBetween(word, candidate);
        if (slips < most) {
            most = slips;
            nearest = &candidate;
        }
    }
    return nearest == nullptr ? "" : "; did you mean " + inQuotes(*nearest) + "?";
}

std::string listed(std::span<const std::string> words)
{
    std::string all;
    for (const std::string& word : words)
        all += (all.empty() ? "" : ", ") + word;
    return all;
}

} // namespace isofront::fields::graph
