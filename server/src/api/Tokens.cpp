#include "Tokens.h"

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>

namespace isofront::server {
namespace {

constexpr std::size_t kShortest = 16;

/// Of a token in a header (RFC 9110, section 5.6.2): a browser's WebSocket names no others.
bool isTokenCharacter(char character)
{
    constexpr std::string_view kOthers = "!#$%&'*+-.^_`|~";
    return (character >= 'a' && character <= 'z') || (character >= 'A' && character <= 'Z') ||
           (character >= '0' && character <= '9') || kOthers.find(character) != kOthers.npos;
}

} // namespace

core::Result<Tokens> Tokens::read(const std::filesystem::path& file)
{
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(file, error);
    std::ifstream in(file, std::ios::binary);
    if (error || !std::filesystem::is_regular_file(status) || !in)
        return core::failure(
            core::ErrorCode::inputOutput, "tokens: " + file.string() + ": can't be read");
    using std::filesystem::perms;
    if ((status.permissions() & (perms::others_read | perms::others_write)) != perms::none)
        return core::failure(
            core::ErrorCode::usage,
            "tokens: " + file.string() + ": everybody on this machine may read it: chmod 600 " +
                file.string());
    std::ostringstream text;
    text << in.rdbuf();
    auto tokens = parse(text.str());
    if (!tokens)
        return tl::unexpected(tokens.error().within("tokens: " + file.string()));
    return tokens;
}

core::Result<Tokens> Tokens::parse(std::string_view text)
{
    Tokens tokens;
    std::istringstream lines{std::string(text)};
    std::size_t number = 0;
    for (std::string line; std::getline(lines, line);) {
        ++number;
        // never the token itself: messages end up in logs
        const auto refused = [&](const std::string& why) {
            return core::failure(
                core::ErrorCode::usage, "line " + std::to_string(number) + ": " + why);
        };
        std::istringstream words(line);
        std::string scopes;
        if (!(words >> scopes) || scopes.starts_with('#'))
            continue;
        Token token;
        std::string secret;
        std::string more;
        if (!(words >> token.principal.name >> secret) || words >> more)
            return refused("not of the form 'scopes name token', as 'read,write alice 2c7e...'");
        if (secret.size() < kShortest || secret.size() > kLongest)
            return refused(
                "a token has " + std::to_string(kShortest) + " to " + std::to_string(kLongest) +
                " characters");
        if (!std::ranges::all_of(secret, isTokenCharacter))
            return refused(
                "a token has letters, digits and !#$%&'*+-.^_`|~ only: browsers can send nothing "
                "else with a WebSocket");
        std::istringstream list(scopes);
        for (std::string name; std::getline(list, name, ',');) {
            const auto scope = scopeNamed(name);
            if (!scope)
                return refused("'" + name + "' is not one of read, write, admin");
            token.principal.scopes = token.principal.scopes.with(*scope);
        }
        token.text = padded(secret);
        token.line = number;
        const auto same = std::ranges::find(tokens._tokens, token.text, &Token::text);
        if (same != tokens._tokens.end())
            return refused(
                "its token is that of line " + std::to_string(same->line) +
                ": each needs one of its own");
        tokens._tokens.push_back(std::move(token));
    }
    if (tokens._tokens.empty())
        return core::failure(
            core::ErrorCode::usage,
            "there is no token in it: write lines 'scopes name token', as 'read,write alice "
            "2c7e...'");
    return tokens;
}

Tokens::Padded Tokens::padded(std::string_view token)
{
    Padded text{};
    std::copy_n(token.begin(), std::min(token.size(), text.size()), text.begin());
    return text;
}

std::optional<Principal> Tokens::principalOf(std::string_view token) const
{
    if (token.empty() || token.size() > kLongest)
        return std::nullopt;
    const Padded given = padded(token);
    const Token* found = nullptr;
    for (const Token& known : _tokens) {
        // volatile, so that no compiler ends the loop at the first difference
        volatile unsigned char difference = 0;
        for (std::size_t i = 0; i < kLongest; ++i)
            difference = static_cast<unsigned char>(difference | (known.text[i] ^ given[i]));
        found = difference == 0 ? &known : found;
    }
    return found != nullptr ? std::optional(found->principal) : std::nullopt;
}

} // namespace isofront::server
