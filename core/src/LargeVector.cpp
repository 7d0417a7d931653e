#include "isofront/core/LargeVector.h"

#if defined(__linux__)
#include <sys/mman.h>
#endif

#include <algorithm>

namespace isofront::core::detail {

namespace {

constexpr std::size_t kLargePage = std::size_t{1} << 21U;

std::align_val_t alignmentFor(std::size_t bytes, std::size_t alignment)
{
    return std::align_val_t{bytes < kLargePage ? alignment : std::max(alignment, kLargePage)};
}

} // namespace

void* allocateLarge(std::size_t bytes, std::size_t alignment)
{
    void* const memory = ::operator new(bytes, alignmentFor(bytes, alignment));
#if defined(__linux__)
    // whole pages only, so that no neighbour's memory is touched; a refusal does no harm
    if (bytes >= kLargePage)
        (void)::madvise(memory, bytes / kLargePage * kLargePage, MADV_HUGEPAGE);
#endif
    return memory;
}

void freeLarge(void* memory, std::size_t bytes, std::size_t alignment) noexcept
{
    ::operator delete(memory, bytes, alignmentFor(bytes, alignment));
}

} // namespace isofront::core::detail
