#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace isofront::cli {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string contentsOf(const fs::path& path)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

/// The real program, in a folder of its own.
class BenchCommand : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "isofront-bench-XXXXXX").string();
        ASSERT_NE(mkdtemp(pattern.data()), nullptr);
        folder = pattern;
    }
    void TearDown() override { fs::remove_all(folder); }

    int run(const std::string& arguments)
    {
        const std::string line = "cd '" + folder.string() +
                                 "' && env -u ISOFRONT_TEST_DATA '" ISOFRONT_BINARY "' bench " +
                                 arguments +
                                 " --data '" ISOFRONT_DATA "/volumes' >stdout 2>stderr </dev/null";
        const int status = std::system(line.c_str());
        output = contentsOf(folder / "stdout");
        errors = contentsOf(folder / "stderr");
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
    }

    fs::path folder;
    std::string output;
    std::string errors;
};

TEST_F(BenchCommand, runsEverySuiteAndWritesWhatReadsBack)
{
    ASSERT_EQ(run("--list --json"), 0) << errors;
    const Json listed = Json::parse(output);
    ASSERT_FALSE(listed.empty());
    ASSERT_EQ(run("--quick -q --json --out all"), 0) << errors;
    const Json report = Json::parse(contentsOf(folder / "all" / "report.json"));
    EXPECT_EQ(Json::parse(output), report);
    ASSERT_EQ(report["suites"].size(), listed.size());
    for (std::size_t i = 0; i < listed.size(); ++i) {
        const std::string name = listed[i]["name"];
        const Json& result = report["suites"][i];
        EXPECT_EQ(result["name"], name);
        EXPECT_FALSE(result["tables"].empty()) << name;
        for (const Json& check : result["checks"])
            EXPECT_TRUE(check["holds"]) << check;
        for (const Json& table : result["tables"]) {
            EXPECT_FALSE(table["rows"].empty()) << name << " " << table["name"];
            for (const Json& row : table["rows"])
                EXPECT_EQ(row.size(), table["columns"].size());
            const std::string csv =
                contentsOf(folder / "all" / (name + "." + std::string(table["name"]) + ".csv"));
            EXPECT_GE(
                static_cast<std::size_t>(std::ranges::count(csv, '\n')), table["rows"].size() + 1);
        }
    }
    const std::string html = contentsOf(folder / "all" / "report.html");
    EXPECT_TRUE(html.starts_with("<!doctype html>"));
    EXPECT_TRUE(html.ends_with("</html>\n"));
    // One that is named runs alone.
    ASSERT_EQ(run("bounds -q --json --out one"), 0) << errors;
    const Json one = Json::parse(output);
    ASSERT_EQ(one["suites"].size(), 1U);
    EXPECT_EQ(one["suites"][0]["name"], "bounds");
}

TEST_F(BenchCommand, refusesWhatItCanNotDoInOneLine)
{
    const auto expectFailure = [this](const std::string& arguments, int code, const char* name) {
        EXPECT_EQ(run(arguments), code) << arguments << ": " << errors;
        EXPECT_EQ(std::ranges::count(errors, '\n'), 1) << errors;
        EXPECT_NE(errors.find(name), std::string::npos) << errors;
        EXPECT_TRUE(output.empty());
    };
    expectFailure("nonsense -q", 2, "accuracy");
    expectFailure("accuracy --quick --full -q", 2, "--full");
    expectFailure("accuracy -q --data /nonexistent", 4, "/nonexistent");
    std::ofstream(folder / "file") << "x";
    expectFailure("accuracy -q --out file/below", 4, "file/below");
}

} // namespace
} // namespace isofront::cli
