#pragma once

#include <isofront/core/Result.h>

#include <cstdint>
#include <istream>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::volume {

/// Without white space, carriage returns included, at both ends.
std::string_view trimmed(std::string_view text);
/// In lower case (ASCII).
std::string lowered(std::string_view text);
/// One line without its end, or nothing at the end of the file or if the line is too long for a
/// header: a binary file must not be read whole in search of a line's end.
std::optional<std::string> readLine(std::istream& stream);
/// A failure if a line of a header has control characters, tabs and a carriage return at its end
/// aside: libraries differ in what they take such a line for, so one could read another header than
/// the one that was checked.
core::Result<void> checkLine(std::string_view line);
/// A decimal integer that is all of the text.
std::optional<std::int64_t> integerFrom(std::string_view text);
/// Decimal integers with white space between them; nothing if there is anything else.
std::optional<std::vector<std::int64_t>> integersFrom(std::string_view text);

} // namespace isofront::volume
