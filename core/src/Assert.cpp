#include "isofront/core/Assert.h"

#include <cstdio>
#include <cstdlib>

namespace isofront::core::detail {

void assertionFailed(const char* condition, const std::string& message, const char* file, int line)
{
    std::fprintf(stderr, "%s:%d: expected %s: %s\n", file, line, condition, message.c_str());
    std::abort();
}

} // namespace isofront::core::detail
