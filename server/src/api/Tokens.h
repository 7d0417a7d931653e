#pragma once

#include "Scope.h"

#include <isofront/core/Result.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace isofront::server {

/// Who has shown a token, and what they may do.
struct Principal {
    std::string name;
    Scopes scopes;
};

/// The bearer tokens that the service knows.
///
/// Thread: immutable.
class Tokens {
public:
    Tokens() = default;

    /// Reads lines `scopes name token`, as `read,write alice 2c7e...`; empty lines and those that
    /// begin with # are skipped. A token has 16 to 256 characters.
    /// Errors: inputOutput if the file can't be read; usage if others may read it, and for lines
    /// that aren't of that form, a token that two have, and a file without any.
    static core::Result<Tokens> read(const std::filesystem::path& file);
    static core::Result<Tokens> parse(std::string_view text);

    /// Nothing for a token that isn't known. How long this takes depends on how many tokens there
    /// are, never on what they have in common with the one given.
    [[nodiscard]] std::optional<Principal> principalOf(std::string_view token) const;
    [[nodiscard]] std::size_t size() const { return _tokens.size(); }

private:
    static constexpr std::size_t kLongest = 256;
    using Padded = std::array<unsigned char, kLongest>;
    struct Token {
        Padded text{};
        std::size_t line = 0; ///< of the file
        Principal principal;
    };

    static Padded padded(std::string_view token);

    std::vector<Token> _tokens;
};

} // namespace isofront::server
