#pragma once

#include <tl/expected.hpp>

#include <string>
#include <utility>

namespace isofront::core {

/// Why something that depends on the outside world failed. The values are the exit codes of the
/// command line.
enum class ErrorCode {
    usage = 2,         ///< what was asked for makes no sense, or names something unknown
    badData = 3,       ///< the input was read, and is not what it should be
    inputOutput = 4,   ///< a file or folder can't be read or written
    noDevice = 5,      ///< no usable Vulkan device
    resourceLimit = 6, ///< the work would exceed the budget given
    interrupted = 130, ///< the user stopped it
};

/// A failure in one sentence: what, where, why, and what to do about it.
struct Error {
    ErrorCode code = ErrorCode::badData;
    std::string message;

    /// The same error seen from further out, as "context: message".
    [[nodiscard]] Error within(const std::string& context) const;
};

/// Bad data, I/O and devices fail through values; misuse asserts; exceptions stay inside a module.
template <typename T>
using Result = tl::expected<T, Error>;

inline tl::unexpected<Error> failure(ErrorCode code, std::string message)
{
    return tl::unexpected<Error>(Error{code, std::move(message)});
}

} // namespace isofront::core
