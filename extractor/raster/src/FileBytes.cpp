#include "isofront/raster/FileBytes.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <memory>
#include <string>
#include <system_error>

namespace isofront::raster {

using core::ErrorCode;
using core::failure;

core::Result<void> checkReadable(const std::filesystem::path& path)
{
    std::error_code failed;
    const auto status = std::filesystem::status(path, failed);
    if (!std::filesystem::exists(status))
        return failure(ErrorCode::inputOutput, "there is no such file; check the path");
    if (!std::filesystem::is_regular_file(status))
        return failure(ErrorCode::inputOutput, "it is not a regular file; name a file with data");
    errno = 0;
    if (!std::ifstream(path, std::ios::binary))
        return failure(
            ErrorCode::inputOutput,
            "the file can't be opened (" + std::generic_category().message(errno) +
                "); check its permissions");
    if (std::filesystem::file_size(path, failed) == 0)
        return failure(ErrorCode::badData, "the file is empty; get it again");
    return {};
}

core::Result<std::vector<std::byte>>
readFileBytes(const std::filesystem::path& path, std::uint64_t mostBytes, ErrorCode whenMore)
{
    if (const auto readable = checkReadable(path); !readable)
        return tl::unexpected(readable.error());
    // zlib reads plain files as they are.
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> file(gzopen(path.c_str(), "rb"), gzclose);
    if (!file)
        return failure(ErrorCode::inputOutput, "the file can't be opened; check its permissions");

    constexpr std::size_t kChunk = std::size_t{1} << 18U;
    std::vector<std::byte> bytes;
    // of files that aren't packed it is all: growing would take twice as much for a while
    constexpr std::uint64_t kMostReserved = std::uint64_t{1} << 36U;
    std::error_code unknown;
    const std::uint64_t size = std::filesystem::file_size(path, unknown);
    if (!unknown && size <= std::min(mostBytes, kMostReserved))
        bytes.reserve(static_cast<std::size_t>(size) + kChunk);
    while (true) {
        const std::size_t held = bytes.size();
        bytes.resize(held + kChunk);
        const int read = gzread(file.get(), bytes.data() + held, kChunk);
        if (read < 0)
            return failure(
                ErrorCode::badData,
                "the compressed data are damaged after " + std::to_string(held) +
                    " bytes; get the file again");
        bytes.resize(held + static_cast<std::size_t>(read));
        if (bytes.size() > mostBytes)
            return failure(
                whenMore,
                "the file holds more than the " + std::to_string(mostBytes) +
                    (whenMore == ErrorCode::resourceLimit ? " bytes that were allowed for"
                                                          : " bytes that such a file can have"));
        if (static_cast<std::size_t>(read) < kChunk)
            break;
    }
    int state = Z_OK;
    gzerror(file.get(), &state);
    if (state != Z_OK) // Z_BUF_ERROR: the stream ends in the middle
        return failure(
            ErrorCode::badData,
            "the compressed data are cut short after " + std::to_string(bytes.size()) +
                " bytes; get the file again");
    return bytes;
}

} // namespace isofront::raster
