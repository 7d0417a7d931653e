#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace isofront::server {

/// A folder that goes with the test.
class TemporaryFolder {
public:
    TemporaryFolder()
    {
        std::string pattern =
            (std::filesystem::temp_directory_path() / "isofront-server-XXXXXX").string();
        path = mkdtemp(pattern.data());
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }

    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        std::filesystem::create_directories((path / name).parent_path());
        std::ofstream(path / name, std::ios::binary) << text;
        return path / name;
    }

    std::filesystem::path path;
};

/// A raw volume of `edge`^3 bytes: a ball in the middle.
inline std::string ballVolume(int edge)
{
    std::string bytes;
    const double centre = 0.5 * (edge - 1);
    for (int z = 0; z < edge; ++z)
        for (int y = 0; y < edge; ++y)
            for (int x = 0; x < edge; ++x) {
                const double square = (x - centre) * (x - centre) + (y - centre) * (y - centre) +
                                      (z - centre) * (z - centre);
                bytes += static_cast<char>(square < 0.1 * edge * edge ? 200 : 10);
            }
    return bytes;
}

/// What the service has to be told of it.
inline std::string ballLayout(int edge)
{
    const std::string size = std::to_string(edge);
    return size + "x" + size + "x" + size + ",uint8";
}

} // namespace isofront::server
