#pragma once

#include "isofront/core/Jobs.h"

namespace isofront::core {

std::unique_ptr<Jobs> makeTbbJobs(std::size_t threads);

} // namespace isofront::core
