#include "Turns.h"

#include <utility>

namespace isofront::surface {

namespace {

/// Set while this thread hands something over: who finds it set runs inside that very call.
thread_local bool* ranAtOnce = nullptr;

} // namespace

bool handOver(core::Jobs& jobs, std::function<void()> rest)
{
    bool isAtOnce = false;
    ranAtOnce = &isAtOnce;
    jobs.submit([rest = std::move(rest)] {
        if (ranAtOnce != nullptr)
            *ranAtOnce = true;
        else
            rest();
    });
    ranAtOnce = nullptr;
    return !isAtOnce;
}

} // namespace isofront::surface
