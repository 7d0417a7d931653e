#pragma once

#include <isofront/core/Image.h>
#include <isofront/core/Result.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace isofront::exchange {

struct VideoOptions {
    int width = 1280;            ///< [px], of every frame
    int height = 720;            ///< [px]
    double framesPerSecond = 30; ///< > 0 and finite
    int quality = 18; ///< x264's constant rate factor, 0 (exact) to 51; 18 looks lossless
    std::string program = "ffmpeg"; ///< found along PATH unless it has a slash
};

/// Encodes frames as H.264 in MP4, by an `ffmpeg` process that is optional on the machine.
///
/// The file appears under its name only when `finish` succeeded; without it the process is ended
/// and nothing is left. Players want even sizes, so an odd last row or column is doubled. No shell
/// is involved, and an encoder that dies is an error here, never a signal.
///
/// Thread: one at a time.
class VideoWriter {
public:
    /// Whether the program is there to be run.
    static bool available(const std::string& program = "ffmpeg");

    /// Starts the encoder. Fails with `usage` for a size or rate that is none, and `inputOutput` if
    /// the program or the folder is missing.
    static core::Result<VideoWriter>
    open(const std::filesystem::path& path, const VideoOptions& options);

    VideoWriter(VideoWriter&&) noexcept;
    VideoWriter& operator=(VideoWriter&&) noexcept;
    VideoWriter(const VideoWriter&) = delete;
    VideoWriter& operator=(const VideoWriter&) = delete;
    ~VideoWriter();

    /// Hands over the next frame; waits while the encoder is busy. Fails with `usage` for a frame
    /// of another size, `inputOutput` with the encoder's last words if it died; then the video is
    /// lost.
    core::Result<void> add(const core::Image& frame);

    /// Waits for the encoder and gives the file its name.
    /// @return the file's length [bytes]; `usage` if there was no frame
    core::Result<std::uint64_t> finish();

private:
    class Encoder;
    explicit VideoWriter(std::unique_ptr<Encoder> encoder);

    std::unique_ptr<Encoder> _encoder; ///< null once finished or failed
};

} // namespace isofront::exchange
