#pragma once

#include <isofront/core/Jobs.h>

#include <functional>

namespace isofront::surface {

/// Puts the rest of a long job at the end of the line, so that others who share the jobs have
/// their turn.
///
/// Where jobs run at once on the thread that hands them over, nobody waits in line, and each turn
/// would only nest one call deeper: then nothing is handed over.
/// @return false if so: the caller is to go on itself. Otherwise the rest may already be running,
///         or be done.
bool handOver(core::Jobs& jobs, std::function<void()> rest);

} // namespace isofront::surface
