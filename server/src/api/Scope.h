#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace isofront::server {

/// What somebody may do. Each stands alone: a token to write that can't read is a drop box.
enum class Scope : std::uint8_t {
    none = 0,  ///< needs no permission
    read = 1,  ///< see scenes
    write = 2, ///< create, upload and delete scenes
    admin = 4, ///< see how the service fares
};

/// A set of scopes.
class Scopes {
public:
    constexpr Scopes() = default;
    constexpr Scopes(Scope scope) : _bits(static_cast<std::uint8_t>(scope)) {}

    [[nodiscard]] constexpr Scopes with(Scopes other) const
    {
        Scopes both;
        both._bits = static_cast<std::uint8_t>(_bits | other._bits);
        return both;
    }
    [[nodiscard]] constexpr bool contain(Scope scope) const
    {
        return (_bits & static_cast<std::uint8_t>(scope)) == static_cast<std::uint8_t>(scope);
    }
    friend constexpr bool operator==(Scopes, Scopes) = default;

private:
    std::uint8_t _bits = 0;
};

constexpr std::string_view nameOf(Scope scope)
{
    switch (scope) {
    case Scope::none:
        return "none";
    case Scope::read:
        return "read";
    case Scope::write:
        return "write";
    case Scope::admin:
        return "admin";
    }
    return "";
}

/// Nothing for a word that names no scope.
constexpr std::optional<Scope> scopeNamed(std::string_view name)
{
    for (const Scope scope : {Scope::read, Scope::write, Scope::admin})
        if (name == nameOf(scope))
            return scope;
    return std::nullopt;
}

} // namespace isofront::server
