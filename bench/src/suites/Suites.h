#pragma once

#include "isofront/bench/Suite.h"

namespace isofront::bench {

// One function a suite; what each answers stands in the list of Suite.cpp.

SuiteResult runAccuracy(const Context& context);

} // namespace isofront::bench
