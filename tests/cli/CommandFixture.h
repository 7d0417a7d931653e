#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace isofront::cli {

namespace fs = std::filesystem;

struct Outcome {
    int exitCode = -1;
    std::string output;
    std::string errors;
};

inline std::string contentsOf(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// The real program, in a folder of its own.
class Command : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "isofront-test-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder = pattern;
    }
    void TearDown() override { fs::remove_all(folder); }

    Outcome run(const std::string& arguments, const std::string& environment = "") const
    {
        const fs::path out = folder / "stdout";
        const fs::path err = folder / "stderr";
        const std::string line = "cd '" + folder.string() + "' && " + environment +
                                 " '" ISOFRONT_BINARY "' " + arguments + " >'" + out.string() +
                                 "' 2>'" + err.string() + "' </dev/null";
        const int status = std::system(line.c_str());
        return {
            WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            contentsOf(out),
            contentsOf(err)};
    }

    /// Fails with this code and one line that names all of these.
    void expectFailure(
        const std::string& arguments,
        int code,
        const std::vector<std::string>& names,
        const std::string& environment = "") const
    {
        const Outcome outcome = run(arguments + " -q", environment);
        EXPECT_EQ(outcome.exitCode, code) << arguments << "\n" << outcome.errors;
        EXPECT_EQ(std::ranges::count(outcome.errors, '\n'), 1) << arguments << "\n"
                                                               << outcome.errors;
        EXPECT_TRUE(outcome.errors.starts_with("isofront: ")) << outcome.errors;
        EXPECT_TRUE(outcome.output.empty()) << outcome.output;
        for (const std::string& name : names)
            EXPECT_NE(outcome.errors.find(name), std::string::npos)
                << arguments << " should name " << name << ": " << outcome.errors;
    }

    void write(const std::string& name, const std::string& text) const
    {
        std::ofstream(folder / name, std::ios::binary) << text;
    }

    /// A raw NRRD volume of 32-bit floats.
    void writeNrrd(
        const std::string& name,
        std::array<std::size_t, 3> size,
        const std::vector<float>& values) const
    {
        std::ostringstream header;
        header << "NRRD0004\ntype: float\ndimension: 3\nsizes: " << size[0] << ' ' << size[1] << ' '
               << size[2] << "\nspacings: 1 1 1\nendian: little\nencoding: raw\n\n";
        std::string text = header.str();
        const std::size_t begin = text.size();
        text.resize(begin + values.size() * sizeof(float));
        std::memcpy(text.data() + begin, values.data(), values.size() * sizeof(float));
        write(name, text);
    }

    fs::path folder;
};

} // namespace isofront::cli
