#pragma once

#include <cstdint>

namespace isofront::core {

/// Mixes all bits of a word into all bits of the result; a bijection.
/// Source: Stafford's variant 13 of the MurmurHash3 finaliser.
constexpr std::uint64_t mixed(std::uint64_t word)
{
    word ^= word >> 30U;
    word *= 0xbf58476d1ce4e5b9ULL;
    word ^= word >> 27U;
    word *= 0x94d049bb133111ebULL;
    word ^= word >> 31U;
    return word;
}

/// Folds one more word into a hash. Coordinates of lattice points end in many zero bits, so every
/// word is mixed, never merely combined by exclusive or.
constexpr std::uint64_t hashCombined(std::uint64_t hash, std::uint64_t word)
{
    return mixed(hash * 0x9e3779b97f4a7c15ULL + word);
}

} // namespace isofront::core
