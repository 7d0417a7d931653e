#include "ExchangeFixture.h"

#include <isofront/exchange/Video.h>

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <array>
#include <cstdio>
#include <limits>

namespace isofront::exchange::test {

namespace {

class VideoTest : public ExchangeTest {
protected:
    /// An encoder that is a shell script.
    std::string fakeEncoder(const std::string& body)
    {
        setContent(path("encoder"), "#!/bin/sh\n" + body);
        EXPECT_EQ(::chmod(path("encoder").c_str(), 0755), 0);
        return path("encoder").string();
    }
};

core::Image frameOf(int width, int height, int step)
{
    core::Image image{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            image.rgba.insert(
                image.rgba.end(),
                {static_cast<std::uint8_t>(x + step),
                 static_cast<std::uint8_t>(y),
                 static_cast<std::uint8_t>(40),
                 255});
    return image;
}

/// What ffprobe says about the one stream: size, frames, pixel format, rate.
std::string probed(const std::filesystem::path& path)
{
    const std::string command =
        "ffprobe -v error -count_frames -select_streams v -show_entries "
        "stream=codec_name,width,height,pix_fmt,avg_frame_rate,nb_read_frames -of csv=p=0 '" +
        path.string() + "' 2>&1";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    EXPECT_NE(pipe, nullptr);
    std::array<char, 512> text{};
    const std::size_t count = std::fread(text.data(), 1, text.size() - 1, pipe);
    EXPECT_EQ(::pclose(pipe), 0);
    return {text.data(), count};
}

} // namespace

TEST_F(VideoTest, encodesEveryFrameAtEvenSizes)
{
    ASSERT_TRUE(VideoWriter::available()) << "install ffmpeg";
    const std::pair<std::pair<int, int>, const char*> sizes[] = {
        {{64, 48}, "64,48"}, {{65, 47}, "66,48"}, {{1, 1}, "2,2"}};
    for (const auto& [size, expected] : sizes) {
        VideoOptions options;
        options.width = size.first;
        options.height = size.second;
        options.framesPerSecond = 24;
        auto video = VideoWriter::open(path("a: b.mp4"), options);
        ASSERT_TRUE(video) << video.error().message;
        for (int i = 0; i < 10; ++i) {
            const auto added = video->add(frameOf(options.width, options.height, i));
            ASSERT_TRUE(added) << added.error().message;
        }
        EXPECT_FALSE(std::filesystem::exists(path("a: b.mp4")));
        const auto bytes = video->finish();
        ASSERT_TRUE(bytes) << bytes.error().message;
        EXPECT_EQ(*bytes, std::filesystem::file_size(path("a: b.mp4")));
        EXPECT_EQ(probed(path("a: b.mp4")), "h264," + std::string(expected) + ",yuv420p,24/1,10\n");
        const std::string content = contentOf(path("a: b.mp4"));
        EXPECT_LT(content.find("moov"), content.find("mdat")) << "a browser can start at once";
        EXPECT_FALSE(video->add(frameOf(options.width, options.height, 0)));
        EXPECT_FALSE(video->finish());
        std::filesystem::remove(path("a: b.mp4"));
    }
}

TEST_F(VideoTest, leavesNothingWhenDroppedAndKeepsTheOldFile)
{
    ASSERT_TRUE(VideoWriter::available()) << "install ffmpeg";
    setContent(path("a.mp4"), "old");
    {
        VideoOptions options;
        options.width = options.height = 32;
        auto video = VideoWriter::open(path("a.mp4"), options);
        ASSERT_TRUE(video) << video.error().message;
        ASSERT_TRUE(video->add(frameOf(32, 32, 0)));
        VideoWriter moved = std::move(*video);
        ASSERT_TRUE(moved.add(frameOf(32, 32, 1)));
    }
    EXPECT_EQ(names(), std::vector<std::string>{"a.mp4"});
    EXPECT_EQ(contentOf(path("a.mp4")), "old");
}

TEST_F(VideoTest, quotesTheLastWordsOfAnEncoderThatDies)
{
    VideoOptions options;
    options.width = options.height = 512;
    options.program =
        fakeEncoder("for i in 1 2 3 4 5 6; do echo \"trouble $i\" >&2; done\nexit 1\n");
    auto video = VideoWriter::open(path("a.mp4"), options);
    ASSERT_TRUE(video) << video.error().message;
    core::Result<void> added;
    for (int i = 0; i < 1000 && added; ++i)
        added = video->add(frameOf(512, 512, i));
    ASSERT_FALSE(added) << "and no SIGPIPE";
    EXPECT_EQ(added.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(
        added.error().message.find("trouble 3 | trouble 4 | trouble 5 | trouble 6"),
        std::string::npos)
        << added.error().message;
    EXPECT_EQ(names(), std::vector<std::string>{"encoder"});
}

TEST_F(VideoTest, failsAtTheEndIfTheEncoderDoes)
{
    VideoOptions options;
    options.width = options.height = 8;
    // Many words must not block it either.
    options.program =
        fakeEncoder("cat >/dev/null\nhead -c 300000 /dev/zero | tr '\\0' 'w' >&2\necho >&2\n"
                    "echo no codec >&2\nexit 3\n");
    auto video = VideoWriter::open(path("a.mp4"), options);
    ASSERT_TRUE(video) << video.error().message;
    ASSERT_TRUE(video->add(frameOf(8, 8, 0)));
    const auto finished = video->finish();
    ASSERT_FALSE(finished);
    EXPECT_NE(finished.error().message.find("no codec"), std::string::npos);
    EXPECT_LT(finished.error().message.size(), 5000U);
    EXPECT_EQ(names(), std::vector<std::string>{"encoder"});
}

TEST_F(VideoTest, refusesWhatIsNoVideo)
{
    const VideoOptions bad[] = {
        {.width = 0},
        {.height = -3},
        {.width = 20'000},
        {.framesPerSecond = 0},
        {.framesPerSecond = std::numeric_limits<double>::quiet_NaN()},
        {.quality = 99}};
    for (const VideoOptions& options : bad) {
        const auto video = VideoWriter::open(path("a.mp4"), options);
        ASSERT_FALSE(video);
        EXPECT_EQ(video.error().code, core::ErrorCode::usage);
    }
    VideoOptions options;
    options.width = options.height = 8;
    options.program = fakeEncoder("cat >/dev/null\n");
    auto video = VideoWriter::open(path("a.mp4"), options);
    ASSERT_TRUE(video) << video.error().message;
    EXPECT_EQ(video->add(frameOf(8, 9, 0)).error().code, core::ErrorCode::usage);
    EXPECT_EQ(video->finish().error().code, core::ErrorCode::usage) << "no frames";
    EXPECT_EQ(names(), std::vector<std::string>{"encoder"});
}

TEST_F(VideoTest, saysThatTheProgramOrTheFolderIsMissing)
{
    VideoOptions options;
    options.program = "no-such-encoder";
    EXPECT_FALSE(VideoWriter::available(options.program));
    EXPECT_FALSE(VideoWriter::available(""));
    EXPECT_FALSE(VideoWriter::available(folder().string()));
    const auto video = VideoWriter::open(path("a.mp4"), options);
    ASSERT_FALSE(video);
    EXPECT_EQ(video.error().code, core::ErrorCode::inputOutput);
    EXPECT_NE(video.error().message.find("install ffmpeg"), std::string::npos);
    options.program = fakeEncoder("exit 0\n");
    EXPECT_EQ(
        VideoWriter::open(path("none") / "a.mp4", options).error().code,
        core::ErrorCode::inputOutput);
    std::filesystem::create_symlink("/dev/null", path("null.mp4"));
    EXPECT_FALSE(VideoWriter::open(path("null.mp4"), options));
}

} // namespace isofront::exchange::test
