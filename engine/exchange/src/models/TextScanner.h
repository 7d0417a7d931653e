#pragma once

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

namespace isofront::exchange {

/// Whether a line that ends in a backslash goes on in the next one.
enum class Continuation : bool { none, backslash };

/// Words and numbers of a text file, line by line.
class TextScanner {
public:
    explicit TextScanner(
        std::span<const std::byte> bytes, Continuation continuation = Continuation::none)
        : _text(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
          _continuation(continuation)
    {
    }

    /// Goes to the next line; false at the end. What begins with # goes on nowhere.
    bool nextLine()
    {
        if (_next >= _text.size())
            return false;
        _line += _lines;
        _lines = 1;
        std::size_t end = endAfter(_next);
        if (_continuation == Continuation::backslash &&
            _text[std::min(_text.find_first_not_of(" \t", _next), end - 1)] != '#')
            for (; continuesBefore(end) && end < _text.size(); ++_lines)
                end = endAfter(end);
        _rest = _text.substr(_next, end - _next);
        _next = end;
        return true;
    }
    /// The next word of the line; empty at its end.
    std::string_view word()
    {
        const auto isBlank = [&](std::size_t at) {
            const char c = _rest[at];
            return c == ' ' || c == '\t' || c == '\r' || c == '\n' ||
                   (c == '\\' && continuesAt(at));
        };
        std::size_t begin = 0;
        while (begin < _rest.size() && isBlank(begin))
            ++begin;
        _rest.remove_prefix(begin);
        std::size_t length = 0;
        while (length < _rest.size() && !isBlank(length))
            ++length;
        const std::string_view word = _rest.substr(0, length);
        _rest.remove_prefix(length);
        return word;
    }
    /// What is left of the line, without blanks around: for names that may have some within.
    std::string_view rest()
    {
        const std::size_t begin = std::min(_rest.find_first_not_of(" \t\r\n"), _rest.size());
        const std::size_t end = _rest.find_last_not_of(" \t\r\n") + 1; // 0 where there is none
        const std::string_view rest = begin < end ? _rest.substr(begin, end - begin) : "";
        _rest = {};
        return rest;
    }
    /// The next word as a number; nothing if it isn't one. Infinite and undefined ones are numbers.
    template <typename T>
    std::optional<T> number()
    {
        return numberOf<T>(word());
    }
    template <typename T>
    static std::optional<T> numberOf(std::string_view word)
    {
        if (!word.empty() && word.front() == '+')
            word.remove_prefix(1);
        T value{};
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error == std::errc::invalid_argument || end != word.data() + word.size())
            return std::nullopt;
        return error == std::errc::result_out_of_range ? nearest<T>(word) : value;
    }

    [[nodiscard]] std::size_t line() const { return _line; }
    /// Where the next line begins.
    [[nodiscard]] std::size_t position() const { return _next; }
    /// "line 12: what"
    [[nodiscard]] std::string at(const std::string& what) const
    {
        return "line " + std::to_string(_line) + ": " + what;
    }

private:
    /// Behind the end of the line that a place lies in; the last one may have none.
    [[nodiscard]] std::size_t endAfter(std::size_t at) const
    {
        const std::size_t end = _text.find('\n', at);
        return end == std::string_view::npos ? _text.size() : end + 1;
    }
    /// Whether the line that ends there ends in a backslash.
    [[nodiscard]] bool continuesBefore(std::size_t end) const
    {
        for (const char last : {'\n', '\r'})
            if (end > _next && _text[end - 1] == last)
                --end;
        return end > _next && _text[end - 1] == '\\';
    }
    /// Whether only the end of a line follows in what is left.
    [[nodiscard]] bool continuesAt(std::size_t backslash) const
    {
        if (_continuation == Continuation::none)
            return false;
        std::size_t next = backslash + 1;
        if (next < _rest.size() && _rest[next] == '\r')
            ++next;
        return next == _rest.size() || _rest[next] == '\n';
    }
    /// What comes nearest to a number that its type can't hold: the largest, or nothing at all.
    template <typename T>
    static T nearest(std::string_view word)
    {
        if constexpr (std::is_floating_point_v<T>)
            return static_cast<T>(std::strtod(std::string(word).c_str(), nullptr));
        else
            return word.front() == '-' ? std::numeric_limits<T>::min()
                                       : std::numeric_limits<T>::max();
    }

    std::string_view _text;
    std::string_view _rest;
    Continuation _continuation;
    std::size_t _next = 0;
    std::size_t _line = 0;
    std::size_t _lines = 1; ///< of the file, in the line
};

} // namespace isofront::exchange
