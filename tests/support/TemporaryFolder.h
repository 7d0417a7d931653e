#pragma once

#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <string>
#include <system_error>

namespace isofront::tests {

/// A folder of its own, gone at the end of the test.
class TemporaryFolder {
public:
    TemporaryFolder()
    {
        static std::atomic<int> count = 0;
        _path = std::filesystem::temp_directory_path() /
                ("isofront-test-" + std::to_string(getpid()) + "-" + std::to_string(count++));
        std::filesystem::create_directories(_path);
    }
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    ~TemporaryFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(_path, ignored);
    }

    /// Writes a file with these bytes and returns its path.
    [[nodiscard]] std::filesystem::path
    file(const std::string& name, const std::string& bytes) const
    {
        std::filesystem::create_directories((_path / name).parent_path());
        std::ofstream stream(_path / name, std::ios::binary);
        stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        return _path / name;
    }
    [[nodiscard]] std::filesystem::path path(const std::string& name) const { return _path / name; }

private:
    std::filesystem::path _path;
};

} // namespace isofront::tests
