// The charts follow Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with
// View-Dependent Level of Detail and Applications", Fig. 12: frame time and triangles over a
// flight.

#include "report/FlightReport.h"

#include <isofront/charts/Page.h>
#include <isofront/charts/SvgChart.h>
#include <isofront/exchange/OutputFile.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string_view>
#include <system_error>

namespace isofront::cli {

using charts::Chart;
using charts::ChartSeries;
using charts::escaped;
using charts::svgOf;

namespace {

std::string formatted(const char* format, double value)
{
    std::array<char, 64> text{};
    (void)std::snprintf(text.data(), text.size(), format, value);
    return text.data();
}

std::string millisecondsText(double value)
{
    if (!std::isfinite(value))
        return "\u2013";
    return formatted(value < 10 ? "%.2f" : value < 100 ? "%.1f" : "%.0f", value);
}

/// Three digits and a suffix: "845", "12.3 k", "4.56 M".
std::string countText(double value)
{
    if (value < 1000)
        return formatted("%.0f", value);
    const auto [unit, suffix] = value < 999.5e3   ? std::pair{1e3, " k"}
                                : value < 999.5e6 ? std::pair{1e6, " M"}
                                                  : std::pair{1e9, " G"};
    const double scaled = value / unit;
    return formatted(scaled < 9.995 ? "%.2f" : scaled < 99.95 ? "%.1f" : "%.0f", scaled) + suffix;
}

struct ByteUnit {
    double bytes;
    const char* name;
};

ByteUnit byteUnitFor(double bytes)
{
    constexpr double kKibi = 1024;
    return bytes < kKibi                   ? ByteUnit{1, "B"}
           : bytes < kKibi * kKibi         ? ByteUnit{kKibi, "KiB"}
           : bytes < kKibi * kKibi * kKibi ? ByteUnit{kKibi * kKibi, "MiB"}
                                           : ByteUnit{kKibi * kKibi * kKibi, "GiB"};
}

std::string bytesText(double bytes)
{
    const ByteUnit unit = byteUnitFor(bytes);
    const double scaled = bytes / unit.bytes;
    return formatted(
               unit.bytes == 1 || scaled >= 99.95 ? "%.0f"
               : scaled < 9.995                   ? "%.2f"
                                                  : "%.1f",
               scaled) +
           " " + unit.name;
}

std::string tile(const std::string& value, const std::string& name)
{
    return "<div class=\"tile\"><b>" + escaped(value) + "</b><span>" + escaped(name) +
           "</span></div>\n";
}

/// Whether there is anything to tell of meshes; without voxels, nothing is told, too.
bool hasMeshes(const FlightSummary& summary)
{
    return summary.maxTriangles > 0 || summary.maxVoxels == 0;
}

std::string tilesHtml(const FlightSummary& summary, std::size_t frames)
{
    const auto share = [](std::uint64_t part, std::uint64_t whole) {
        return whole == 0
                   ? std::string("\u2013")
                   : formatted(
                         "%.0f %%", 100 * static_cast<double>(part) / static_cast<double>(whole));
    };
    const std::uint64_t cells =
        summary.cellsExtracted + summary.cellsSkipped + summary.cellsFromCache;
    std::string html = "<div class=\"tiles\">\n" +
                       tile(
                           millisecondsText(summary.cpuMilliseconds.p50) + " ms",
                           "processor time of the median frame") +
                       tile(
                           millisecondsText(summary.cpuMilliseconds.p99) + " ms",
                           "processor time that 99 % of the frames stay below") +
                       tile(
                           std::isfinite(summary.gpuMilliseconds.p50)
                               ? millisecondsText(summary.gpuMilliseconds.p50) + " ms"
                               : "not measured",
                           "device time of the median frame");
    if (summary.maxVoxels > 0)
        html += tile(countText(static_cast<double>(summary.maxVoxels)), "voxels at most");
    if (hasMeshes(summary))
        html += tile(countText(static_cast<double>(summary.maxTriangles)), "triangles at most") +
                tile(
                    countText(static_cast<double>(summary.cellsExtracted)),
                    "cells extracted, " + share(summary.cellsExtracted, cells) + " of all") +
                tile(
                    countText(static_cast<double>(summary.cellsSkipped)),
                    "cells proved empty and skipped, " + share(summary.cellsSkipped, cells)) +
                tile(
                    countText(static_cast<double>(summary.cellsFromCache)),
                    "cells from the cache, " + share(summary.cellsFromCache, cells));
    return html +
           tile(
               bytesText(static_cast<double>(summary.maxResidentBytes)),
               "memory of the process at most") +
           tile(
               bytesText(static_cast<double>(summary.uploadedBytes)),
               "uploaded in " + std::to_string(frames) + " frames") +
           "</div>\n";
}

std::string spreadRow(const char* name, const Spread& spread)
{
    std::string row = "<tr><th scope=\"row\">" + escaped(name) + "</th>";
    for (const double value : {spread.mean, spread.p50, spread.p95, spread.p99, spread.max})
        row += "<td>" + millisecondsText(value) + "</td>";
    return row + "</tr>\n";
}

std::string spreadHtml(const FlightSummary& summary)
{
    return "<section><h2>Time of a frame [ms]</h2>\n<div class=\"scroll\"><table>\n<thead><tr>"
           "<th></th><th>mean</th><th>p50</th><th>p95</th><th>p99</th><th>max</th></tr></thead>\n"
           "<tbody>\n" +
           spreadRow("Processor", summary.cpuMilliseconds) +
           spreadRow("of it, update", summary.updateMilliseconds) +
           spreadRow("Device", summary.gpuMilliseconds) + "</tbody></table></div></section>\n";
}

std::string chartHtml(const Chart& chart)
{
    std::string html = "<section><h2>" + escaped(chart.title) + "</h2>\n<div class=\"legend\">";
    for (const ChartSeries& series : chart.series)
        html += "<span class=\"" + escaped(series.style) + "\"><i></i>" + escaped(series.name) +
                (series.onRight ? " (right)" : "") + "</span>";
    // Text in a picture shrinks with it, so a phone gets a picture of its own size.
    return html + "</div>\n<div class=\"wide\">" + svgOf(chart, 960, 300) +
           "</div><div class=\"narrow\">" + svgOf(chart, 360, 250) + "</div></section>\n";
}

class Charts {
public:
    explicit Charts(const std::vector<FrameRecord>& frames) : _frames(frames) {}

    [[nodiscard]] Chart
    chart(const char* title, const std::string& left, const char* right = "") const
    {
        return {
            title,
            "time of flight [s]",
            left,
            right,
            values([](const FrameRecord& frame) { return frame.time; }),
            {}};
    }
    [[nodiscard]] std::vector<double>
    values(const std::function<double(const FrameRecord&)>& value, double unit = 1) const
    {
        std::vector<double> result;
        result.reserve(_frames.size());
        for (const FrameRecord& frame : _frames)
            result.push_back(value(frame) / unit);
        return result;
    }
    [[nodiscard]] std::vector<double>
    counts(std::uint64_t FrameRecord::*member, double unit = 1) const
    {
        return values(
            [member](const FrameRecord& frame) { return static_cast<double>(frame.*member); },
            unit);
    }

private:
    const std::vector<FrameRecord>& _frames;
};

std::string chartsHtml(const std::vector<FrameRecord>& frames, const FlightSummary& summary)
{
    const Charts charts(frames);

    const char* shown = hasMeshes(summary) ? "triangles" : "voxels";
    Chart time = charts.chart((std::string("Frame time and ") + shown).c_str(), "[ms]", shown);
    time.series = {
        {"processor", "a", charts.values([](const auto& f) { return f.cpuMilliseconds; })},
        {"device", "b", charts.values([](const auto& f) { return f.gpuMilliseconds; })},
        {shown,
         "c",
         charts.counts(hasMeshes(summary) ? &FrameRecord::triangles : &FrameRecord::voxels),
         true}};

    Chart cells = charts.chart("Cells", "cells a frame, logarithmic");
    cells.series = {
        {"proved empty and skipped", "c", charts.counts(&FrameRecord::cellsSkipped)},
        {"extracted", "a", charts.counts(&FrameRecord::cellsExtracted)},
        {"from the cache", "b", charts.counts(&FrameRecord::cellsFromCache)},
        {"still pending", "d", charts.counts(&FrameRecord::cellsPending)}};
    cells.isLogarithmic = true;

    const ByteUnit memoryUnit = byteUnitFor(static_cast<double>(std::max(
        {summary.maxResidentBytes,
         summary.maxDeviceBytes,
         summary.maxMeshBytes,
         summary.maxCacheBytes})));
    Chart memory = charts.chart("Memory", std::string("[") + memoryUnit.name + "]");
    memory.series = {
        {"process", "a", charts.counts(&FrameRecord::residentBytes, memoryUnit.bytes)},
        {"device", "b", charts.counts(&FrameRecord::deviceBytes, memoryUnit.bytes)},
        {"meshes shown", "c", charts.counts(&FrameRecord::meshBytes, memoryUnit.bytes)},
        {"cache", "d", charts.counts(&FrameRecord::cacheBytes, memoryUnit.bytes)}};
    if (!hasMeshes(summary)) {
        memory.series.resize(2);
        memory.series.push_back(
            {"voxels", "c", charts.counts(&FrameRecord::voxelBytes, memoryUnit.bytes)});
    }

    const ByteUnit uploadUnit = byteUnitFor(static_cast<double>(summary.maxUploadedBytes));
    Chart uploads = charts.chart("Uploads", std::string("[") + uploadUnit.name + " a frame]");
    uploads.series = {
        {"uploaded to the device",
         "c",
         charts.counts(&FrameRecord::uploadedBytes, uploadUnit.bytes)}};

    std::string html = chartHtml(time) + (hasMeshes(summary) ? chartHtml(cells) : "") +
                       chartHtml(memory) + chartHtml(uploads);
    if (std::isfinite(summary.largestPop.max)) {
        Chart popping = charts.chart(
            "What changed without a movement", "of a square of 8 x 8 pixels [0 to 255]");
        popping.series = {
            {"the most", "a", charts.values([](const auto& f) { return f.largestPop; })},
            {"in the mean", "c", charts.values([](const auto& f) { return f.meanPop; })}};
        popping.isLogarithmic = true;
        html += chartHtml(popping);
    }
    if (summary.maxVoxels == 0)
        return html;
    if (!hasMeshes(summary))
        return html;
    Chart far = charts.chart("The far field", "voxels and triangles", "blocks");
    far.series = {
        {"voxels", "c", charts.counts(&FrameRecord::voxels)},
        {"triangles", "a", charts.counts(&FrameRecord::triangles)},
        {"blocks shown as voxels", "b", charts.counts(&FrameRecord::voxelBlocks), true},
        {"blocks shown as meshes", "d", charts.counts(&FrameRecord::meshBlocks), true}};
    return html + chartHtml(far);
}

/// A relative path as the address of a link.
std::string addressOf(const std::filesystem::path& path)
{
    std::string address;
    for (const char c : path.generic_string()) {
        const bool isPlain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                             (c >= '0' && c <= '9') ||
                             std::string_view("-._~/").find(c) != std::string_view::npos;
        if (isPlain)
            address += c;
        else {
            std::array<char, 4> code{};
            (void)std::snprintf(
                code.data(), code.size(), "%%%02X", unsigned{static_cast<unsigned char>(c)});
            address += code.data();
        }
    }
    // A first part with a colon would otherwise name a scheme.
    return path.is_absolute() ? "file://" + address : "./" + address;
}

std::string mediaHtml(const FlightReport& report, const std::filesystem::path& folder)
{
    const auto exists = [&folder](const std::filesystem::path& file) {
        std::error_code ignored;
        return !file.empty() && std::filesystem::is_regular_file(folder / file, ignored);
    };
    std::string html;
    if (exists(report.video))
        html += "<video controls muted playsinline preload=\"metadata\" src=\"" +
                addressOf(report.video) + "\"></video>\n";
    if (exists(report.contactSheet))
        html += "<img alt=\"Frames of the flight, in order\" src=\"" +
                addressOf(report.contactSheet) + "\">\n";
    return html.empty() ? html : "<section><h2>What was seen</h2>\n" + html + "</section>\n";
}

std::string settingsHtml(const FlightSettings& settings)
{
    std::vector<std::pair<std::string, std::string>> rows = {
        {"Source", settings.source},
        {"Preset", settings.preset},
        {"Seed", std::to_string(settings.seed)},
        {"Size",
         std::to_string(settings.width) + " \u00d7 " + std::to_string(settings.height) + " pixels"},
        {"Pixel error",
         std::isfinite(settings.pixelError) ? formatted("%g", settings.pixelError) : ""},
        {"Device", settings.device},
        {"Threads", std::to_string(settings.threads)}};
    rows.insert(rows.end(), settings.others.begin(), settings.others.end());
    rows.insert(rows.end(), settings.versions.begin(), settings.versions.end());
    std::string html = "<section><h2>Settings</h2>\n<table class=\"settings\"><tbody>\n";
    for (const auto& [name, value] : rows)
        if (!value.empty())
            html += "<tr><th scope=\"row\">" + escaped(name) + "</th><td>" + escaped(value) +
                    "</td></tr>\n";
    return html + "</tbody></table></section>\n";
}

std::string headingHtml(const FlightReport& report, const FlightSummary& summary)
{
    const FlightSettings& settings = report.settings;
    std::string what = std::to_string(report.frames.size()) + " frames";
    if (summary.seconds > 0)
        what += " in " + formatted("%.1f s", summary.seconds);
    what += " at " + std::to_string(settings.width) + " \u00d7 " + std::to_string(settings.height);
    if (std::isfinite(settings.pixelError))
        what += ", pixel error " + formatted("%g", settings.pixelError);
    if (!settings.device.empty())
        what += ", on " + settings.device;
    const std::string name =
        settings.source + (settings.preset.empty() ? "" : ", " + settings.preset);
    return "<h1>Flight over " + escaped(name) + "</h1>\n<p class=\"what\">" + escaped(what) +
           "</p>\n";
}

} // namespace

core::Result<std::uint64_t>
writeReportHtml(const FlightReport& report, const std::filesystem::path& path)
{
    const FlightSummary summary = summarised(report.frames);
    std::string html =
        charts::pageBegin("Flight over " + report.settings.source) + headingHtml(report, summary);
    if (report.frames.empty())
        html += "<section><p>No frame was flown, so there is nothing to show.</p></section>\n";
    else
        html += tilesHtml(summary, report.frames.size()) + mediaHtml(report, path.parent_path()) +
                chartsHtml(report.frames, summary) + spreadHtml(summary);
    html += settingsHtml(report.settings) + charts::pageEnd();
    return exchange::writeFile(path, html);
}

} // namespace isofront::cli
