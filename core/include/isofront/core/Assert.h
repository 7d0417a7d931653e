#pragma once

#include <string>

namespace isofront::core::detail {

/// Prints the failed expectation to standard error and aborts.
[[noreturn]] void
assertionFailed(const char* condition, const std::string& message, const char* file, int line);

} // namespace isofront::core::detail

/// Misuse of an interface: a sentence with the values that broke the expectation. On wherever
/// NDEBUG is not defined, and in builds with ISOFRONT_CHECKED. Bad data is never an assertion.
#if !defined(NDEBUG) || defined(ISOFRONT_CHECKED)
#define ISOFRONT_ASSERT(condition, message)                                                        \
    (static_cast<bool>(condition)                                                                  \
         ? void(0)                                                                                 \
         : ::isofront::core::detail::assertionFailed(#condition, (message), __FILE__, __LINE__))
#else
#define ISOFRONT_ASSERT(condition, message) void(sizeof(!(condition)))
#endif
