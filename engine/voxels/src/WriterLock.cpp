#include "WriterLock.h"

#include "Durability.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

namespace isofront::voxels {

namespace {

constexpr mode_t kMode = 0644;

/// Whether a name still is that of an open file: another process may have given it a new one, or
/// removed it, before this one had the lock.
bool isNameOf(const std::filesystem::path& path, int descriptor)
{
    struct stat named {};
    struct stat opened {};
    return ::lstat(path.c_str(), &named) == 0 && ::fstat(descriptor, &opened) == 0 &&
           named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

} // namespace

core::Result<WriterLock>
WriterLock::take(const std::filesystem::path& path, const std::filesystem::path& asked)
{
    return take(path, asked, false);
}

core::Result<WriterLock>
WriterLock::takeFolder(const std::filesystem::path& path, const std::filesystem::path& asked)
{
    return take(path, asked, true);
}

core::Result<WriterLock> WriterLock::take(
    const std::filesystem::path& path, const std::filesystem::path& asked, bool isFolder)
{
    const auto fail = [&](const std::string& why) -> core::Result<WriterLock> {
        return core::failure(core::ErrorCode::inputOutput, asked.string() + ": " + why);
    };
    for (;;) {
        constexpr mode_t kFolderMode = 0777;
        if (isFolder && ::mkdir(path.c_str(), kFolderMode) != 0 && errno != EEXIST)
            return fail("can't be made: " + writeFailure(errno));
        const int flags = isFolder ? O_RDONLY | O_DIRECTORY : O_RDWR | O_CREAT;
        WriterLock lock(::open(path.c_str(), flags | O_NOFOLLOW | O_CLOEXEC, kMode));
        if (lock._descriptor < 0 && isFolder && errno == ENOENT)
            continue; // another process has just removed it
        if (lock._descriptor < 0)
            return fail("can't be made: " + writeFailure(errno));
        if (::flock(lock._descriptor, LOCK_EX | LOCK_NB) != 0)
            return fail(
                errno == EWOULDBLOCK
                    ? "another process is writing it; wait for it or choose another name"
                    : "can't be locked: " + writeFailure(errno));
        if (!isNameOf(path, lock._descriptor))
            continue;
        if (!isFolder && ::ftruncate(lock._descriptor, 0) != 0)
            return fail("can't be made: " + writeFailure(errno));
        return lock;
    }
}

WriterLock::WriterLock(WriterLock&& other) noexcept
    : _descriptor(std::exchange(other._descriptor, -1))
{
}

WriterLock::~WriterLock()
{
    if (_descriptor >= 0)
        ::close(_descriptor);
}

} // namespace isofront::voxels
