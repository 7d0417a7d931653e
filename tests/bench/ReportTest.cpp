#include <isofront/bench/Report.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace isofront::bench {
namespace {

BenchReport sampleReport()
{
    Table table{
        "numbers",
        "Some <numbers>",
        {{"method", "", "how"}, {"size", "", "how much"}, {"error", "px", "how wrong"}},
        {},
        {{"error", "Error over size", "size", "error", "method", "", "", true, true, {-1}}}};
    for (int i = 1; i <= 5; ++i) {
        table.add({"a, \"b\"", count(1000 * i), 1.0 / 3 / i});
        table.add({"c", count(500 * i), i == 3 ? std::nan("") : 0.5 / i});
    }
    BenchReport report;
    report.machine = {"A processor", 2, "System", "Compiler", "0.1", {{"AVX2", 100.5}}};
    report.runs = {
        {"some", "Is it so?", 1.5, {{table}, {{"it holds", true, "1 < 2"}}, {"by <hand>"}}}};
    return report;
}

std::string contentOf(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(Table, writesCsvThatReadsBackTheSameNumbers)
{
    const std::string csv = csvOf(sampleReport().runs[0].result.tables[0]);
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < csv.size();) {
        const std::size_t end = csv.find("\r\n", at);
        lines.push_back(csv.substr(at, end - at));
        at = end + 2;
    }
    ASSERT_EQ(lines.size(), 11U);
    EXPECT_EQ(lines[0], "method,size,error [px]");
    EXPECT_TRUE(lines[1].starts_with("\"a, \"\"b\"\"\",1000,"));
    EXPECT_EQ(std::stod(lines[1].substr(lines[1].rfind(',') + 1)), 1.0 / 3);
    EXPECT_EQ(lines[6], "c,1500,") << "what was not measured is empty";
}

TEST(Table, showsNumbersAsPeopleReadThem)
{
    EXPECT_EQ(textOf(count(1234567)), "1,234,567");
    EXPECT_EQ(textOf(count(-1234)), "-1,234");
    EXPECT_EQ(textOf(count(-123)), "-123");
    EXPECT_EQ(textOf(count(0)), "0");
    EXPECT_EQ(textOf(0.123456), "0.1235");
    EXPECT_EQ(textOf(std::numeric_limits<double>::infinity()), "-");
}

TEST(BenchReport, writesAPageTablesAndPicturesThatAgree)
{
    const auto folder =
        std::filesystem::temp_directory_path() / ("isofront-bench-" + std::to_string(::getpid()));
    const BenchReport report = sampleReport();
    const auto written = writeBenchReport(report, folder / "new");
    ASSERT_TRUE(written) << written.error().message;
    const auto json = nlohmann::json::parse(contentOf(folder / "new" / "report.json"));
    EXPECT_EQ(json.at("format"), "isofront.bench");
    EXPECT_EQ(json.at("machine").at("fma_gigaflops").at("AVX2"), 100.5);
    const auto& table = json.at("suites").at(0).at("tables").at(0);
    ASSERT_EQ(table.at("rows").size(), 10U);
    EXPECT_EQ(table.at("rows").at(0).at(2), 1.0 / 3);
    EXPECT_TRUE(table.at("rows").at(5).at(2).is_null());
    const std::string html = contentOf(folder / "new" / "report.html");
    for (const char* const text :
         {"Is it so?", "Some &lt;numbers&gt;", "<polyline", "A processor", "1,000", "1 &lt; 2"})
        EXPECT_NE(html.find(text), std::string::npos) << text;
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("src=\"http"), std::string::npos);
    EXPECT_EQ(
        contentOf(folder / "new" / "some.numbers.csv"), csvOf(report.runs[0].result.tables[0]));
    EXPECT_TRUE(contentOf(folder / "new" / "some.error.svg").starts_with("<svg "));
    EXPECT_TRUE(report.allChecksHold());
    std::filesystem::remove_all(folder);
    std::ofstream(folder.string()) << "a file";
    EXPECT_EQ(writeBenchReport(report, folder / "x").error().code, core::ErrorCode::inputOutput);
    std::filesystem::remove_all(folder);
}

TEST(Suites, haveNamesOfTheirOwnAndAreFoundByThem)
{
    for (const Suite& suite : suites()) {
        EXPECT_EQ(std::ranges::count(suites(), suite.name, &Suite::name), 1) << suite.name;
        EXPECT_TRUE(suite.question.ends_with("?")) << suite.name;
        const auto found = suitesNamed({suite.name});
        ASSERT_TRUE(found);
        ASSERT_EQ(found->size(), 1U);
        EXPECT_EQ(found->front().name, suite.name);
    }
    EXPECT_EQ(suitesNamed({})->size(), suites().size());
    const auto unknown = suitesNamed({"accuracy", "nonsense"});
    ASSERT_FALSE(unknown);
    EXPECT_EQ(unknown.error().code, core::ErrorCode::usage);
    EXPECT_NE(unknown.error().message.find("accuracy"), std::string::npos);
}

TEST(FmaRates, growWithTheWidthOfTheInstructionSet)
{
    const auto rates = fmaRates();
    ASSERT_FALSE(rates.empty());
    for (const FmaRate& rate : rates) {
        EXPECT_GT(rate.gigaflops, 0.5) << rate.instructionSet;
        EXPECT_LT(rate.gigaflops, 2000) << rate.instructionSet << ": was the loop left out?";
    }
    EXPECT_GT(rates.front().gigaflops, rates.back().gigaflops) << "best first";
}

TEST(Timed, countsRunsAndProcessorTime)
{
    int calls = 0;
    volatile double sink = 0;
    const Timing timing = timed(
        [&] {
            ++calls;
            for (int i = 0; i < 1000000; ++i)
                sink = sink + 1;
        },
        7,
        60);
    EXPECT_EQ(calls, 7);
    EXPECT_EQ(timing.runs, 7U);
    EXPECT_GT(timing.least, 1e-5);
    EXPECT_LE(timing.least, timing.median);
    EXPECT_EQ(timed([] {}, 1000, 0).runs, 1U) << "no further run once the time is up";
}

} // namespace
} // namespace isofront::bench
