#include "ScratchFile.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <utility>

namespace isofront::voxels {

core::Result<ScratchFile> ScratchFile::create(const std::filesystem::path& folder)
{
    std::error_code failed;
    const std::filesystem::path where =
        folder.empty() ? std::filesystem::temp_directory_path(failed) : folder;
    std::string name = (where / "isofront-XXXXXX").string();
    const int descriptor = ::mkostemp(name.data(), O_CLOEXEC);
    if (descriptor < 0)
        return core::failure(
            core::ErrorCode::inputOutput,
            where.string() + ": no temporary file can be made there: " + std::strerror(errno) +
                "; name another folder");
    ::unlink(name.c_str());
    return ScratchFile(descriptor, where);
}

ScratchFile::ScratchFile(int descriptor, std::filesystem::path folder)
    : _descriptor(descriptor), _folder(std::move(folder))
{
}

ScratchFile::ScratchFile(ScratchFile&& other) noexcept
    : _descriptor(std::exchange(other._descriptor, -1)), _folder(std::move(other._folder)),
      _end(other._end)
{
}

ScratchFile::~ScratchFile()
{
    if (_descriptor >= 0)
        ::close(_descriptor);
}

core::Error ScratchFile::error(const char* what, int number) const
{
    return {
        core::ErrorCode::inputOutput,
        _folder.string() + ": a temporary file can't be " + what + ": " + std::strerror(number) +
            (number == ENOSPC ? "; free some space, or name another folder" : "")};
}

core::Result<std::uint64_t> ScratchFile::append(std::span<const std::byte> bytes)
{
    std::uint64_t offset = 0;
    {
        const std::scoped_lock lock(_mutex);
        offset = _end;
        _end += bytes.size();
    }
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t written = ::pwrite(
            _descriptor,
            bytes.data() + done,
            bytes.size() - done,
            static_cast<off_t>(offset + done));
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return tl::unexpected(error("written", written < 0 ? errno : ENOSPC));
        done += static_cast<std::size_t>(written);
    }
    return offset;
}

std::optional<core::Error> ScratchFile::read(std::uint64_t offset, std::span<std::byte> bytes) const
{
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t got = ::pread(
            _descriptor,
            bytes.data() + done,
            bytes.size() - done,
            static_cast<off_t>(offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got <= 0)
            return error("read", got < 0 ? errno : EIO);
        done += static_cast<std::size_t>(got);
    }
    return std::nullopt;
}

} // namespace isofront::voxels
