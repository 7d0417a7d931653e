#pragma once

#include <isofront/core/Result.h>

#include <nlohmann/json.hpp>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace isofront::fields::graph {

using Json = nlohmann::ordered_json;

/// What is wrong with a preset; doesn't leave this module.
struct Problem {
    std::string message;
    core::ErrorCode code = core::ErrorCode::badData;
};

/// How many bytes the text of a preset may have.
inline constexpr std::size_t kMostBytes = std::size_t{1} << 20U;

/// Reads JSON that is no longer than `kMostBytes`, no deeper than 100 brackets, and has no key
/// twice in one object; a library alone would keep the last of them.
/// Throws Problem, with line and column, what stands there, and what should.
Json parsedJson(std::string_view text);

/// A piece of someone's text as it may stand in an error: in quotes, on one line, and cut off after
/// `most` bytes.
std::string inQuotes(std::string_view text, std::size_t most = 40);

/// "; did you mean 'octaves'?" if one of the words is only a slip away, else nothing.
std::string suggestion(std::string_view word, std::span<const std::string> words);

/// The words with commas between them.
std::string listed(std::span<const std::string> words);

} // namespace isofront::fields::graph
