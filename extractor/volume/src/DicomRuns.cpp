#include "DicomRuns.h"

#include <isofront/core/Assert.h>

#include <cstdint>

namespace isofront::volume {

namespace {

constexpr std::size_t kMostSegments = 15;
constexpr std::size_t kHeaderBytes = 4 * (1 + kMostSegments);

std::uint32_t numberAt(std::span<const char> bytes, std::size_t at)
{
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < 4; ++i)
        number |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
    return number;
}

/// One segment: the bytes of one place in all pixels, as runs and literals.
/// @return false if they don't come to as many bytes as there are pixels
bool unpackSegment(
    std::span<const char> packed, std::size_t place, std::size_t bytesOfPixel, std::span<char> into)
{
    std::size_t to = place;
    const auto put = [&](char byte) {
        if (to >= into.size())
            return false;
        into[to] = byte;
        to += bytesOfPixel;
        return true;
    };
    for (std::size_t at = 0; at < packed.size() && to < into.size();) {
        const int head = static_cast<signed char>(packed[at++]);
        if (head == -128)
            continue; // says nothing
        const auto count = static_cast<std::size_t>(head < 0 ? 1 - head : 1 + head);
        const std::size_t bytes = head < 0 ? 1 : count;
        if (packed.size() - at < bytes)
            return false;
        for (std::size_t i = 0; i < count; ++i)
            if (!put(packed[at + (head < 0 ? 0 : i)]))
                return false;
        at += bytes;
    }
    return to >= into.size();
}

} // namespace

core::Result<void>
unpackDicomRuns(std::span<const char> packed, std::size_t bytesOfPixel, std::span<char> into)
{
    ISOFRONT_ASSERT(
        bytesOfPixel >= 1 && bytesOfPixel <= 4 && into.size() % bytesOfPixel == 0,
        "there must be room for whole pixels");
    const auto damaged = core::failure(
        core::ErrorCode::badData, "its runs of pixels are damaged or cut short; get it again");
    if (packed.size() < kHeaderBytes || numberAt(packed, 0) != bytesOfPixel)
        return damaged;
    for (std::size_t segment = 0; segment < bytesOfPixel; ++segment) {
        const std::size_t begin = numberAt(packed, 4 * (1 + segment));
        const std::size_t end =
            segment + 1 < bytesOfPixel ? numberAt(packed, 4 * (2 + segment)) : packed.size();
        // The first segment has the highest byte of each pixel.
        if (begin < kHeaderBytes || begin > end || end > packed.size() ||
            !unpackSegment(
                packed.subspan(begin, end - begin), bytesOfPixel - 1 - segment, bytesOfPixel, into))
            return damaged;
    }
    return {};
}

} // namespace isofront::volume
