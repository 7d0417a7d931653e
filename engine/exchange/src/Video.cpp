#include "isofront/exchange/Video.h"

#include "isofront/exchange/OutputFile.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <locale>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

extern char** environ; // NOLINT(readability-identifier-naming): POSIX names it

namespace isofront::exchange {

namespace {

constexpr std::size_t kLastWords = 4; // lines of the encoder's messages to quote
constexpr std::size_t kMostMessageBytes = 4096;

class Descriptor {
public:
    Descriptor() = default;
    explicit Descriptor(int number) : _number(number) {}
    Descriptor(Descriptor&& other) noexcept : _number(std::exchange(other._number, -1)) {}
    Descriptor& operator=(Descriptor&& other) noexcept
    {
        std::swap(_number, other._number);
        return *this;
    }
    ~Descriptor() { reset(); }

    [[nodiscard]] int get() const { return _number; }
    void reset()
    {
        if (_number >= 0)
            ::close(_number);
        _number = -1;
    }

private:
    int _number = -1;
};

core::Error cannotRun(const std::string& program, int errorNumber)
{
    return {
        core::ErrorCode::inputOutput,
        "can't run \"" + program + "\": " + std::generic_category().message(errorNumber) +
            "; install ffmpeg, or do without the video"};
}

/// Starts a program with these three streams, in a process group of its own: a Ctrl-C at the
/// terminal is ours to handle, and must not cut the video short.
core::Result<pid_t>
spawned(const std::vector<std::string>& arguments, int input, int output, int messages)
{
    std::vector<char*> argv;
    argv.reserve(arguments.size() + 1);
    for (const std::string& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str())); // posix_spawn doesn't write to them
    argv.push_back(nullptr);

    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&actions, input, STDIN_FILENO);
    posix_spawn_file_actions_adddup2(&actions, output, STDOUT_FILENO);
    posix_spawn_file_actions_adddup2(&actions, messages, STDERR_FILENO);
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK);
    pid_t process = -1;
    const int errorNumber =
        ::posix_spawnp(&process, argv[0], &actions, &attributes, argv.data(), environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&actions);
    if (errorNumber != 0)
        return tl::unexpected(cannotRun(arguments.front(), errorNumber));
    return process;
}

std::vector<std::string> encoderArguments(
    const VideoOptions& options, int width, int height, const std::filesystem::path& target)
{
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    std::ostringstream rate;
    rate.imbue(std::locale::classic());
    rate << options.framesPerSecond;
    std::error_code ignored;
    // "file:" keeps a name with a colon from being read as a protocol.
    const std::string output = "file:" + std::filesystem::absolute(target, ignored).string();
    // clang-format off
    return {
        options.program, "-hide_banner", "-loglevel", "error", "-y",
        // what comes
        "-f", "rawvideo", "-pix_fmt", "rgba", "-video_size", size, "-framerate", rate.str(),
        "-i", "pipe:0", "-an",
        // the colours of high definition, converted and also declared
        "-vf", "scale=out_color_matrix=bt709:out_range=tv",
        "-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "bt709",
        "-color_range", "tv",
        // what every browser plays, and can start before it has all of it
        "-c:v", "libx264", "-preset", "medium", "-crf", std::to_string(options.quality),
        "-pix_fmt", "yuv420p", "-movflags", "+faststart", "-f", "mp4", output};
    // clang-format on
}

} // namespace

class VideoWriter::Encoder {
public:
    Encoder(OutputFile file, const std::filesystem::path& path, const VideoOptions& options)
        : _file(std::move(file)), _name(path.string()), _width(options.width),
          _height(options.height), _evenWidth(options.width + options.width % 2),
          _evenHeight(options.height + options.height % 2)
    {
    }
    Encoder(const Encoder&) = delete;
    Encoder& operator=(const Encoder&) = delete;
    ~Encoder()
    {
        if (_process > 0)
            ::kill(_process, SIGKILL);
        (void)exitStatus();
    }

    core::Result<void> start(const VideoOptions& options)
    {
        // A socket instead of a pipe, because only a socket can be written without the risk of
        // SIGPIPE; a file in memory for the messages, because nobody needs to empty it meanwhile.
        std::array<int, 2> ends{-1, -1};
        if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
            return tl::unexpected(cannotRun(options.program, errno));
        Descriptor theirs(ends[1]);
        _frames = Descriptor(ends[0]);
        (void)::shutdown(theirs.get(), SHUT_WR);
        _messages = Descriptor(::memfd_create("encoder-messages", MFD_CLOEXEC));
        const Descriptor nowhere(::open("/dev/null", O_WRONLY | O_CLOEXEC));
        if (_messages.get() < 0 || nowhere.get() < 0)
            return tl::unexpected(cannotRun(options.program, errno));
        const core::Result<pid_t> process = spawned(
            encoderArguments(options, _evenWidth, _evenHeight, _file.temporaryPath()),
            theirs.get(),
            nowhere.get(),
            _messages.get());
        if (!process)
            return tl::unexpected(process.error());
        _process = *process;
        return {};
    }

    [[nodiscard]] bool fits(const core::Image& frame) const
    {
        return frame.width == _width && frame.height == _height &&
               frame.rgba.size() ==
                   4 * static_cast<std::size_t>(_width) * static_cast<std::size_t>(_height);
    }
    [[nodiscard]] core::Error misfit(const core::Image& frame) const
    {
        return {
            core::ErrorCode::usage,
            "a frame of " + std::to_string(frame.width) + " x " + std::to_string(frame.height) +
                " pixels doesn't fit \"" + _name + "\", which is " + std::to_string(_width) +
                " x " + std::to_string(_height) + "; keep one size"};
    }

    core::Result<void> send(const core::Image& frame)
    {
        if (_evenWidth == _width && _evenHeight == _height)
            return sendBytes(frame.rgba.data(), frame.rgba.size());
        _padded.clear();
        for (int y = 0; y < _evenHeight; ++y) {
            const std::uint8_t* row = frame.pixel(0, std::min(y, _height - 1));
            const std::uint8_t* end = row + 4 * static_cast<std::ptrdiff_t>(_width);
            _padded.insert(_padded.end(), row, end);
            if (_evenWidth != _width)
                _padded.insert(_padded.end(), end - 4, end);
        }
        return sendBytes(_padded.data(), _padded.size());
    }

    core::Result<std::uint64_t> finish()
    {
        if (_count == 0)
            return core::failure(
                core::ErrorCode::usage,
                "\"" + _name + "\" got no frames; a video needs at least one");
        _frames.reset();
        if (exitStatus() != 0)
            return tl::unexpected(died());
        return _file.commit();
    }

private:
    core::Result<void> sendBytes(const std::uint8_t* bytes, std::size_t count)
    {
        while (count > 0) {
            const ssize_t sent = ::send(_frames.get(), bytes, count, MSG_NOSIGNAL);
            if (sent < 0 && errno == EINTR)
                continue;
            if (sent <= 0) {
                _frames.reset();
                (void)exitStatus();
                return tl::unexpected(died());
            }
            bytes += sent;
            count -= static_cast<std::size_t>(sent);
        }
        ++_count;
        return {};
    }

    /// Waits for the process. @return 0 if it ended well
    int exitStatus()
    {
        int status = -1;
        while (_process > 0) {
            const pid_t ended = ::waitpid(_process, &status, 0);
            if (ended == _process || (ended < 0 && errno != EINTR))
                _process = -1;
        }
        return status;
    }

    [[nodiscard]] core::Error died() const
    {
        const std::string words = lastWords();
        return {
            core::ErrorCode::inputOutput,
            "the video encoder gave up on \"" + _name +
                "\": " + (words.empty() ? std::string("it said nothing") : words) +
                "; check the disk and that ffmpeg has libx264"};
    }

    [[nodiscard]] std::string lastWords() const
    {
        const off_t end = ::lseek(_messages.get(), 0, SEEK_END);
        const auto length =
            std::min(static_cast<std::size_t>(std::max<off_t>(end, 0)), kMostMessageBytes);
        std::string text(length, '\0');
        const ssize_t got =
            ::pread(_messages.get(), text.data(), length, end - static_cast<off_t>(length));
        text.resize(static_cast<std::size_t>(std::max<ssize_t>(got, 0)));

        std::vector<std::string> lines;
        std::istringstream stream(text);
        for (std::string line; std::getline(stream, line);)
            if (line.find_first_not_of(" \r\t") != std::string::npos)
                lines.push_back(line);
        const std::size_t first = lines.size() - std::min(lines.size(), kLastWords);
        std::string words;
        for (std::size_t i = first; i < lines.size(); ++i)
            words += (words.empty() ? "" : " | ") + lines[i];
        return words;
    }

    OutputFile _file;
    std::string _name;
    int _width;
    int _height;
    int _evenWidth;
    int _evenHeight;
    std::vector<std::uint8_t> _padded;
    std::uint64_t _count = 0;
    Descriptor _frames;
    Descriptor _messages;
    pid_t _process = -1;
};

VideoWriter::VideoWriter(std::unique_ptr<Encoder> encoder) : _encoder(std::move(encoder)) {}
VideoWriter::VideoWriter(VideoWriter&&) noexcept = default;
VideoWriter& VideoWriter::operator=(VideoWriter&&) noexcept = default;
VideoWriter::~VideoWriter() = default;

bool VideoWriter::available(const std::string& program)
{
    const auto isProgram = [](const std::filesystem::path& path) {
        std::error_code ignored;
        return std::filesystem::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
    };
    if (program.empty())
        return false;
    if (program.find('/') != std::string::npos)
        return isProgram(program);
    const char* folders = std::getenv("PATH"); // NOLINT(concurrency-mt-unsafe): nobody sets it
    std::istringstream stream(folders != nullptr ? folders : "/bin:/usr/bin");
    for (std::string folder; std::getline(stream, folder, ':');)
        if (isProgram(std::filesystem::path(folder.empty() ? "." : folder) / program))
            return true;
    return false;
}

core::Result<VideoWriter>
VideoWriter::open(const std::filesystem::path& path, const VideoOptions& options)
{
    constexpr int kMostPixelsASide = 16384; // x264's own limit
    if (options.width < 1 || options.height < 1 || options.width > kMostPixelsASide ||
        options.height > kMostPixelsASide || !std::isfinite(options.framesPerSecond) ||
        options.framesPerSecond <= 0 || options.quality < 0 || options.quality > 51)
        return core::failure(
            core::ErrorCode::usage,
            "no video of " + std::to_string(options.width) + " x " +
                std::to_string(options.height) + " pixels at " +
                std::to_string(options.framesPerSecond) + " frames a second and quality " +
                std::to_string(options.quality) +
                " can be written; sides go from 1 to 16384, quality from 0 to 51");
    if (!available(options.program))
        return tl::unexpected(cannotRun(options.program, ENOENT));
    core::Result<OutputFile> file = OutputFile::create(path);
    if (!file)
        return tl::unexpected(file.error());
    if (file->isDirect())
        return core::failure(
            core::ErrorCode::inputOutput,
            "can't write a video to \"" + path.string() +
                "\": it is no file, and MP4 is not written in one go; name a file");
    auto encoder = std::make_unique<Encoder>(std::move(*file), path, options);
    const core::Result<void> started = encoder->start(options);
    if (!started)
        return tl::unexpected(started.error());
    return VideoWriter(std::move(encoder));
}

core::Result<void> VideoWriter::add(const core::Image& frame)
{
    if (_encoder == nullptr)
        return core::failure(
            core::ErrorCode::usage, "the video has ended already; open another for more frames");
    if (!_encoder->fits(frame))
        return tl::unexpected(_encoder->misfit(frame));
    core::Result<void> sent = _encoder->send(frame);
    if (!sent)
        _encoder.reset();
    return sent;
}

core::Result<std::uint64_t> VideoWriter::finish()
{
    if (_encoder == nullptr)
        return core::failure(
            core::ErrorCode::usage, "the video has ended already; open another for more frames");
    core::Result<std::uint64_t> finished = _encoder->finish();
    _encoder.reset();
    return finished;
}

} // namespace isofront::exchange
