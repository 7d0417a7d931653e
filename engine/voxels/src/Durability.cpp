#include "Durability.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace isofront::voxels {

int makeDurable(const std::filesystem::path& path)
{
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0)
        return errno;
    // file systems that have nothing to do for a folder say that it is invalid
    const int failed = ::fsync(descriptor) == 0 || errno == EINVAL ? 0 : errno;
    ::close(descriptor);
    return failed;
}

std::filesystem::path folderOf(const std::filesystem::path& path)
{
    return path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
}

std::string writeFailure(int errorNumber)
{
    // a write that comes to a full disk half-way is EIO to LMDB
    const bool isSpace = errorNumber == ENOSPC || errorNumber == EDQUOT || errorNumber == EIO;
    return std::generic_category().message(errorNumber) +
           (isSpace ? "; is the disk full? free some space, or write elsewhere" : "");
}

} // namespace isofront::voxels
