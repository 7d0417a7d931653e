#include "isofront/exchange/OutputFile.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <utility>

namespace isofront::exchange {

namespace {

constexpr std::size_t kBufferBytes = std::size_t{1} << 20U;
/// Names of temporary files to try before giving up: one is taken only if a killed process with
/// the same id left it.
constexpr int kNameAttempts = 100;

std::string remedyFor(int errorNumber)
{
    switch (errorNumber) {
    case ENOENT:
    case ENOTDIR:
        return "create the folder first";
    case EACCES:
    case EPERM:
    case EROFS:
        return "choose a place that you may write to";
    case ENOSPC:
    case EDQUOT:
        return "free some space or choose another disk";
    case EFBIG:
        return "choose a file system or a limit that allows files of this size";
    case EISDIR:
        return "name a file in it";
    case ENAMETOOLONG:
        return "choose a shorter name";
    default:
        return "check the disk and the path";
    }
}

std::filesystem::path temporaryName(const std::filesystem::path& target)
{
    static std::atomic<unsigned> count{0};
    // The name is cut so that the additions can't push it over the 255 bytes of a file name.
    std::string name{'.'};
    name += target.filename().string().substr(0, 200);
    name += '.' + std::to_string(::getpid()) + '-' + std::to_string(count++) + ".part";
    return target.parent_path() / name;
}

} // namespace

core::Error OutputFile::error(const std::string& what, int errorNumber) const
{
    return {
        core::ErrorCode::inputOutput,
        "can't " + what + " \"" + _asked.string() +
            "\": " + std::generic_category().message(errorNumber) + "; " + remedyFor(errorNumber)};
}

core::Result<OutputFile> OutputFile::create(const std::filesystem::path& path)
{
    OutputFile file;
    file._asked = path;
    file._target = path;
    if (path.filename().empty())
        return tl::unexpected(file.error("write", EISDIR));

    std::error_code ignored;
    if (std::filesystem::is_symlink(path, ignored))
        file._target = std::filesystem::weakly_canonical(path, ignored);

    struct stat status {};
    const bool exists = ::stat(file._target.c_str(), &status) == 0;
    if (exists && S_ISDIR(status.st_mode))
        return tl::unexpected(file.error("write", EISDIR));
    if (exists && !S_ISREG(status.st_mode)) {
        file._descriptor = ::open(file._target.c_str(), O_WRONLY | O_CLOEXEC);
        if (file._descriptor < 0)
            return tl::unexpected(file.error("write", errno));
        return file;
    }
    // A rename would replace a read-only file without a word.
    if (exists && ::access(file._target.c_str(), W_OK) != 0)
        return tl::unexpected(file.error("write", errno));

    for (int attempt = 0; attempt < kNameAttempts && file._descriptor < 0; ++attempt) {
        std::filesystem::path name = temporaryName(file._target);
        file._descriptor = ::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file._descriptor >= 0)
            file._temporary = std::move(name);
        else if (errno != EEXIST)
            return tl::unexpected(file.error("write", errno));
    }
    if (file._descriptor < 0)
        return tl::unexpected(file.error("write", EEXIST));
    if (exists)
        (void)::fchmod(file._descriptor, status.st_mode & 07777U); // keeps who may read it
    return file;
}

OutputFile::OutputFile(OutputFile&& other) noexcept
    : _asked(std::move(other._asked)), _target(std::move(other._target)),
      _temporary(std::move(other._temporary)), _buffer(std::move(other._buffer)),
      _written(other._written), _descriptor(std::exchange(other._descriptor, -1)),
      _errorNumber(other._errorNumber)
{
}

OutputFile& OutputFile::operator=(OutputFile&& other) noexcept
{
    if (this != &other) {
        discard();
        _asked = std::move(other._asked);
        _target = std::move(other._target);
        _temporary = std::move(other._temporary);
        _buffer = std::move(other._buffer);
        _written = other._written;
        _descriptor = std::exchange(other._descriptor, -1);
        _errorNumber = other._errorNumber;
    }
    return *this;
}

OutputFile::~OutputFile()
{
    discard();
}

void OutputFile::discard()
{
    if (_descriptor < 0)
        return;
    ::close(_descriptor);
    _descriptor = -1;
    if (!_temporary.empty())
        ::unlink(_temporary.c_str());
}

void OutputFile::write(std::span<const std::byte> bytes)
{
    if (failed())
        return;
    while (!bytes.empty() && !failed()) {
        const std::size_t count = std::min(bytes.size(), kBufferBytes - _buffer.size());
        _buffer.insert(
            _buffer.end(), bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
        bytes = bytes.subspan(count);
        if (_buffer.size() == kBufferBytes)
            flush();
    }
}

void OutputFile::flush()
{
    std::size_t done = 0;
    while (done < _buffer.size() && _errorNumber == 0) {
        const ssize_t written = ::write(_descriptor, _buffer.data() + done, _buffer.size() - done);
        if (written > 0)
            done += static_cast<std::size_t>(written);
        else if (written == 0)
            _errorNumber = EIO;
        else if (errno != EINTR)
            _errorNumber = errno;
    }
    _written += done;
    _buffer.clear();
}

core::Result<std::uint64_t> OutputFile::commit()
{
    flush();
    if (_errorNumber != 0) {
        discard();
        return tl::unexpected(error("write", _errorNumber));
    }
    std::uint64_t bytes = _written;
    if (!isDirect()) {
        struct stat status {};
        // Some file systems report a full disk only when the data has to reach it.
        if (::fsync(_descriptor) != 0 || ::fstat(_descriptor, &status) != 0) {
            const int errorNumber = errno;
            discard();
            return tl::unexpected(error("write", errorNumber));
        }
        bytes = static_cast<std::uint64_t>(status.st_size);
    }
    const int closed = ::close(std::exchange(_descriptor, -1));
    int errorNumber = closed != 0 ? errno : 0;
    if (errorNumber == 0 && !isDirect() && ::rename(_temporary.c_str(), _target.c_str()) != 0)
        errorNumber = errno;
    if (errorNumber != 0) {
        if (!isDirect())
            ::unlink(_temporary.c_str());
        return tl::unexpected(error("finish writing", errorNumber));
    }
    return bytes;
}

core::Result<std::uint64_t> writeFile(const std::filesystem::path& path, std::string_view content)
{
    core::Result<OutputFile> file = OutputFile::create(path);
    if (!file)
        return tl::unexpected(file.error());
    file->write(content);
    return file->commit();
}

} // namespace isofront::exchange
