#pragma once

#include <algorithm>
#include <cstdlib>
#include <random>

namespace isofront::tests {

/// Scales the number of random trials: 1 by default, more for a longer search
/// (environment variable ISOFRONT_TEST_INTENSITY).
inline int intensity()
{
    const char* text = std::getenv("ISOFRONT_TEST_INTENSITY");
    const int value = text == nullptr ? 1 : std::atoi(text);
    return value > 0 ? value : 1;
}

/// So many trials, times ISOFRONT_TEST_INTENSITY, which may be a fraction here (for sanitizers,
/// under which everything takes many times as long); at least one.
inline int trials(int usual)
{
    const char* text = std::getenv("ISOFRONT_TEST_INTENSITY");
    const double value = text == nullptr ? 1.0 : std::atof(text);
    return std::max(1, static_cast<int>(usual * (value > 0 ? value : 1.0)));
}

/// True unless there are fewer trials than usual: only then can a test ask how much they met.
inline bool areAllTrialsMade()
{
    return trials(100) >= 100;
}

/// A generator with a fixed seed, so that a failure can be repeated.
inline std::mt19937_64 random(std::uint64_t seed)
{
    return std::mt19937_64(seed);
}

template <typename Generator>
double uniform(Generator& generator, double low, double high)
{
    return std::uniform_real_distribution<double>(low, high)(generator);
}

template <typename Generator>
std::size_t below(Generator& generator, std::size_t count)
{
    return std::uniform_int_distribution<std::size_t>(0, count - 1)(generator);
}

} // namespace isofront::tests
