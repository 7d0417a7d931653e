#pragma once

#include <cstdint>

namespace isofront::core {

/// The most memory that this process has held so far [bytes]; 0 where the system doesn't tell.
std::uint64_t peakResidentBytes();

} // namespace isofront::core
