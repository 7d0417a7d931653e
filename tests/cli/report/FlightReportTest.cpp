#include "report/FlightReport.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>

namespace isofront::cli::test {

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class FlightReportTest : public testing::Test {
protected:
    FlightReportTest()
    {
        std::filesystem::remove_all(_folder);
        std::filesystem::create_directories(_folder);
    }
    ~FlightReportTest() override { std::filesystem::remove_all(_folder); }

    [[nodiscard]] std::filesystem::path path(const std::string& name) const
    {
        return _folder / name;
    }

private:
    std::filesystem::path _folder =
        std::filesystem::temp_directory_path() / ("isofront-report-" + std::to_string(::getpid()));
};

std::string contentOf(const std::filesystem::path& path)
{
    std::ifstream file(path, std::ios::binary);
    EXPECT_TRUE(file) << path;
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// A flight like a real one: a busy start, a smooth course, a few spikes.
FlightReport sampleFlight(std::size_t frames)
{
    FlightReport report;
    report.settings = {
        "proc:terrain?seed=7",
        "canyon",
        7,
        1920,
        1080,
        1.5,
        "llvmpipe (LLVM 15.0.6, 256 bits)",
        2,
        {{"Isofront", "0.1.0"}, {"Vulkan", "1.3.275"}},
        {{"Budget", "2 ms a frame"}}};
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 1);
    for (std::size_t i = 0; i < frames; ++i) {
        const double t = static_cast<double>(i) / 60;
        const double course = 1 + 0.5 * std::sin(t * 0.8) + 0.2 * std::sin(t * 3.1);
        const double start = std::exp(-t * 3);
        FrameRecord frame;
        frame.time = t;
        frame.updateMilliseconds = std::abs(0.8 + 0.1 * noise(random) + 2 * start);
        frame.cpuMilliseconds =
            frame.updateMilliseconds + 4 + course + (i % 97 == 50 ? 9 : 0) + 0.2 * noise(random);
        frame.gpuMilliseconds = 3 + 2.2 * course + 0.1 * noise(random);
        frame.triangles = static_cast<std::uint64_t>((1.0 - 0.9 * start) * 1.4e6 * course);
        frame.draws = frame.triangles / 30'000 + 1;
        frame.shownCells = frame.triangles / 900;
        frame.cellsExtracted = static_cast<std::uint64_t>(220 * start + 20 * course);
        frame.cellsSkipped = static_cast<std::uint64_t>(900 * start + 66 * course);
        frame.cellsFromCache = static_cast<std::uint64_t>(t > 4 ? 18 * course : 0);
        frame.cellsPending = static_cast<std::uint64_t>(1500 * start);
        frame.uploadedBytes = frame.cellsExtracted * 14'000;
        frame.meshBytes = frame.triangles * 15;
        frame.cacheBytes = std::min<std::uint64_t>(i * 200'000, 64U << 20U);
        frame.deviceBytes = 180U << 20U;
        frame.residentBytes = (240U << 20U) + frame.meshBytes + frame.cacheBytes;
        frame.eye = {100 * t, 50, 300};
        report.frames.push_back(frame);
    }
    return report;
}

/// Checks that every element that is opened is closed, in order.
void expectWellFormed(const std::string& html)
{
    const std::vector<std::string> voids = {"meta", "img", "!doctype"};
    std::vector<std::string> open;
    for (std::size_t at = html.find('<'); at != std::string::npos; at = html.find('<', at + 1)) {
        const std::size_t end = html.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const std::string tag = html.substr(at + 1, end - at - 1);
        const std::string name = tag.substr(0, tag.find_first_of(" />", 1));
        if (tag.starts_with('/')) {
            ASSERT_FALSE(open.empty()) << tag;
            ASSERT_EQ("/" + open.back(), tag);
            open.pop_back();
        } else if (
            !tag.ends_with('/') && std::find(voids.begin(), voids.end(), name) == voids.end())
            open.push_back(name);
    }
    EXPECT_TRUE(open.empty());
}

void collectKeys(const nlohmann::json& json, std::vector<std::string>& keys)
{
    if (json.is_object())
        for (const auto& [key, value] : json.items()) {
            keys.push_back(key);
            if (key != "versions" && key != "others")
                collectKeys(value, keys);
        }
    if (json.is_array() && !json.empty())
        collectKeys(json.front(), keys);
}

} // namespace

TEST(SpreadOf, isTheNearestRank)
{
    std::mt19937 random(5);
    for (const std::size_t count : {1U, 2U, 3U, 19U, 20U, 21U, 99U, 100U, 101U, 1000U}) {
        std::vector<double> values;
        for (std::size_t i = 0; i < count; ++i)
            values.push_back(static_cast<double>(random() % 50));
        const Spread spread = spreadOf(values);
        const auto check = [&](double percentile, double percent) {
            const auto atMost = [&](double limit) {
                return 100.0 *
                       static_cast<double>(std::count_if(
                           values.begin(), values.end(), [limit](double v) { return v <= limit; }));
            };
            const double wanted = percent * static_cast<double>(count);
            EXPECT_NE(std::find(values.begin(), values.end(), percentile), values.end());
            EXPECT_GE(atMost(percentile), wanted);
            for (const double value : values)
                if (value < percentile) {
                    EXPECT_LT(atMost(value), wanted);
                }
        };
        check(spread.p50, 50);
        check(spread.p95, 95);
        check(spread.p99, 99);
        EXPECT_EQ(spread.max, *std::max_element(values.begin(), values.end()));
    }
}

TEST(SpreadOf, leavesOutWhatWasNotMeasured)
{
    const double values[] = {kNan, 3, 1, kNan, 2, std::numeric_limits<double>::infinity()};
    const Spread spread = spreadOf(values);
    EXPECT_EQ(spread.mean, 2);
    EXPECT_EQ(spread.p50, 2);
    EXPECT_EQ(spread.max, 3);
    EXPECT_TRUE(std::isnan(spreadOf({}).p50));
}

TEST_F(FlightReportTest, writesJsonThatSaysWhatTheFramesDid)
{
    FlightReport report = sampleFlight(300);
    report.frames[3].gpuMilliseconds = kNan;
    const auto bytes = writeReportJson(report, path("report.json"));
    ASSERT_TRUE(bytes) << bytes.error().message;
    const auto json = nlohmann::json::parse(contentOf(path("report.json")));
    EXPECT_EQ(json.at("format"), "isofront.flight");
    EXPECT_EQ(json.at("version"), 1);
    EXPECT_EQ(json.at("settings").at("source"), "proc:terrain?seed=7");
    EXPECT_EQ(json.at("settings").at("versions").at("Vulkan"), "1.3.275");
    ASSERT_EQ(json.at("frames").size(), 300U);
    EXPECT_TRUE(json.at("frames").at(3).at("gpu_ms").is_null());
    std::uint64_t extracted = 0;
    std::uint64_t most = 0;
    for (std::size_t i = 0; i < 300; ++i) {
        const auto& frame = json.at("frames").at(i);
        EXPECT_EQ(frame.at("cpu_ms").get<double>(), report.frames[i].cpuMilliseconds);
        EXPECT_EQ(frame.at("eye").at(0).get<double>(), report.frames[i].eye.x);
        extracted += frame.at("cells_extracted").get<std::uint64_t>();
        most = std::max(most, frame.at("triangles").get<std::uint64_t>());
    }
    const auto& summary = json.at("summary");
    EXPECT_EQ(summary.at("frames"), 300);
    EXPECT_EQ(summary.at("cells_extracted"), extracted);
    EXPECT_EQ(summary.at("triangles_max"), most);
    EXPECT_LE(summary.at("cpu_ms").at("p50"), summary.at("cpu_ms").at("p95"));
    EXPECT_LE(summary.at("gpu_ms").at("p99"), summary.at("gpu_ms").at("max"));
    EXPECT_NEAR(summary.at("seconds").get<double>(), 299.0 / 60, 1e-12);
}

TEST_F(FlightReportTest, documentsEveryKeyOfTheJson)
{
    ASSERT_TRUE(writeReportJson(sampleFlight(2), path("report.json")));
    const std::string document = contentOf(ISOFRONT_REPORT_DOCUMENT);
    std::vector<std::string> keys;
    collectKeys(nlohmann::json::parse(contentOf(path("report.json"))), keys);
    EXPECT_GT(keys.size(), 40U);
    for (const std::string& key : keys)
        EXPECT_NE(document.find("`" + key + "`"), std::string::npos) << key;
}

TEST_F(FlightReportTest, writesAPageThatStandsAlone)
{
    std::ofstream(path("flight #1.mp4")) << "video";
    FlightReport report = sampleFlight(900);
    report.video = "flight #1.mp4";
    report.contactSheet = "missing.png";
    const auto bytes = writeReportHtml(report, path("report.html"));
    ASSERT_TRUE(bytes) << bytes.error().message;
    EXPECT_LT(*bytes, 500'000U);
    const std::string html = contentOf(path("report.html"));
    expectWellFormed(html);
    for (const char* foreign :
         {"http:", "https:", "//", "<script", "@import", "url(", "<link", "onload"})
        EXPECT_EQ(html.find(foreign), std::string::npos) << foreign;
    EXPECT_NE(html.find("src=\"./flight%20%231.mp4\""), std::string::npos);
    EXPECT_EQ(html.find("missing.png"), std::string::npos);
    EXPECT_EQ(html.find("nan"), std::string::npos);
    EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
    for (const char* title : {"Frame time and triangles", "Cells", "Memory", "Uploads"})
        EXPECT_NE(html.find("<h2>" + std::string(title)), std::string::npos);
}

TEST_F(FlightReportTest, tellsOfVoxelsAloneWithoutAWordOfMeshes)
{
    FlightReport report = sampleFlight(30);
    report.settings.pixelError = kNan;
    for (FrameRecord& frame : report.frames) {
        frame.voxels = 5000;
        frame.effectiveVoxelPixels = 1.5;
        frame.triangles = frame.cellsExtracted = frame.cellsSkipped = frame.cellsPending = 0;
    }
    report.frames[7].effectiveVoxelPixels = 2;
    ASSERT_TRUE(writeReportJson(report, path("report.json")));
    const auto json = nlohmann::json::parse(contentOf(path("report.json")));
    EXPECT_TRUE(json.at("settings").at("pixel_error").is_null());
    EXPECT_EQ(json.at("summary").at("effective_voxel_pixels_max"), 2);
    EXPECT_EQ(json.at("frames").at(0).at("effective_voxel_pixels"), 1.5);
    ASSERT_TRUE(writeReportHtml(report, path("report.html")));
    const std::string html = contentOf(path("report.html"));
    expectWellFormed(html);
    EXPECT_NE(html.find("<h2>Frame time and voxels"), std::string::npos);
    for (const char* word : {"nan", "triangles", "cells", "ixel error", "blocks"})
        EXPECT_EQ(html.find(word), std::string::npos) << word;
}

TEST_F(FlightReportTest, escapesAllTextInThePage)
{
    FlightReport report = sampleFlight(3);
    const std::string attack = "</title><script>alert('\"x\"')</script>&";
    report.settings.source = report.settings.preset = report.settings.device = attack;
    report.settings.versions = {{attack, attack}};
    report.settings.others = {{attack, attack}};
    report.video = attack + ".mp4";
    ASSERT_TRUE(writeReportHtml(report, path("report.html")));
    const std::string html = contentOf(path("report.html"));
    expectWellFormed(html);
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("'"), std::string::npos);
    EXPECT_NE(html.find("&lt;script&gt;alert(&#39;&quot;x&quot;"), std::string::npos);
}

TEST_F(FlightReportTest, reportsFlightsWithoutFramesOrDevice)
{
    FlightReport empty;
    ASSERT_TRUE(writeReportHtml(empty, path("report.html")));
    ASSERT_TRUE(writeReportJson(empty, path("report.json")));
    expectWellFormed(contentOf(path("report.html")));
    const auto json = nlohmann::json::parse(contentOf(path("report.json")));
    EXPECT_TRUE(json.at("frames").empty());
    EXPECT_TRUE(json.at("summary").at("cpu_ms").at("p50").is_null());

    FlightReport withoutDevice = sampleFlight(10);
    for (FrameRecord& frame : withoutDevice.frames)
        frame.gpuMilliseconds = kNan;
    ASSERT_TRUE(writeReportHtml(withoutDevice, path("report.html")));
    const std::string html = contentOf(path("report.html"));
    EXPECT_NE(html.find("not measured"), std::string::npos);
    EXPECT_EQ(html.find("nan"), std::string::npos);
}

TEST_F(FlightReportTest, failsWithASentenceWhereTheFolderIsMissing)
{
    EXPECT_EQ(
        writeReportJson({}, path("none") / "report.json").error().code,
        core::ErrorCode::inputOutput);
    EXPECT_EQ(
        writeReportHtml({}, path("none") / "report.html").error().code,
        core::ErrorCode::inputOutput);
}

} // namespace isofront::cli::test
