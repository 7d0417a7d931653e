#include "isofront/bench/Report.h"

#include <isofront/charts/Page.h>
#include <isofront/charts/ScatterChart.h>
#include <isofront/charts/SvgChart.h>
#include <isofront/exchange/OutputFile.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <system_error>

namespace isofront::bench {

namespace {

using charts::escaped;
using Json = nlohmann::ordered_json;

const char* nameOf(Intensity intensity)
{
    return intensity == Intensity::full ? "full" : "quick";
}

std::string labelOf(const Column& column)
{
    std::string text = column.name;
    std::ranges::replace(text, '_', ' ');
    return column.unit.empty() ? text : text + " [" + column.unit + "]";
}

std::string axisOf(const Table& table, const std::string& name)
{
    const Column& column = table.columns[table.column(name)];
    return column.meaning.empty()
               ? labelOf(column)
               : column.meaning + (column.unit.empty() ? "" : " [" + column.unit + "]");
}

charts::ScatterChart chartOf(const Table& table, const Plot& plot)
{
    charts::ScatterChart chart;
    chart.title = plot.title;
    chart.xLabel = axisOf(table, plot.x);
    chart.yLabel = axisOf(table, plot.y);
    chart.isLogarithmicX = plot.isLogarithmicX;
    chart.isLogarithmicY = plot.isLogarithmicY;
    chart.guides = plot.guides;
    for (std::size_t row = 0; row < table.rows.size(); ++row) {
        if (!plot.whereColumn.empty() && table.word(row, plot.whereColumn) != plot.whereWord)
            continue;
        const std::string name = plot.series.empty() ? "" : table.word(row, plot.series);
        auto found = std::ranges::find(chart.series, name, &charts::ScatterSeries::name);
        if (found == chart.series.end())
            found = chart.series.insert(
                found, {name, charts::curveStyle(static_cast<unsigned>(chart.series.size())), {}});
        found->points.emplace_back(table.number(row, plot.x), table.number(row, plot.y));
    }
    return chart;
}

Json cellJson(const Cell& cell)
{
    if (const auto* word = std::get_if<std::string>(&cell))
        return *word;
    if (const auto* count = std::get_if<std::int64_t>(&cell))
        return *count;
    const double value = std::get<double>(cell);
    return std::isfinite(value) ? Json(value) : Json(nullptr); // JSON has no word for NaN
}

Json tableJson(const Table& table)
{
    Json columns = Json::array();
    for (const Column& column : table.columns)
        columns.push_back(
            {{"name", column.name}, {"unit", column.unit}, {"meaning", column.meaning}});
    Json rows = Json::array();
    for (const auto& row : table.rows) {
        Json cells = Json::array();
        for (const Cell& cell : row)
            cells.push_back(cellJson(cell));
        rows.push_back(std::move(cells));
    }
    return {
        {"name", table.name},
        {"title", table.title},
        {"columns", std::move(columns)},
        {"rows", std::move(rows)}};
}

Json machineJson(const Machine& machine)
{
    Json fma = Json::object();
    for (const FmaRate& rate : machine.fma)
        fma[rate.instructionSet] = rate.gigaflops;
    return {
        {"processor", machine.processor},
        {"cores", machine.cores},
        {"system", machine.system},
        {"compiler", machine.compiler},
        {"isofront", machine.version},
        {"fma_gigaflops", std::move(fma)}};
}

std::string tableHtml(const Table& table)
{
    std::string html = "<div class=\"scroll\"><table>\n<thead><tr>";
    for (const Column& column : table.columns)
        html +=
            "<th title=\"" + escaped(column.meaning) + "\">" + escaped(labelOf(column)) + "</th>";
    html += "</tr></thead>\n<tbody>\n";
    for (const auto& row : table.rows) {
        html += "<tr>";
        for (const Cell& cell : row)
            html += "<td>" + escaped(textOf(cell)) + "</td>";
        html += "</tr>\n";
    }
    return html + "</tbody></table></div>\n";
}

std::string runHtml(const SuiteRun& run)
{
    std::string html = "<section id=\"" + escaped(run.name) + "\"><h2>" + escaped(run.name) +
                       "</h2>\n<p class=\"what\">" + escaped(run.question) + "</p>\n";
    for (const std::string& note : run.result.notes)
        html += "<p>" + escaped(note) + "</p>\n";
    for (const Check& check : run.result.checks)
        html += "<p>" + std::string(check.holds ? "\u2713 " : "\u2717 ") + escaped(check.what) +
                ": " + escaped(check.seen) + "</p>\n";
    for (const Table& table : run.result.tables) {
        for (const Plot& plot : table.plots) {
            const charts::ScatterChart chart = chartOf(table, plot);
            // text in a picture shrinks with it, so a phone gets a picture of its own size
            html += "<h2>" + escaped(plot.title) + "</h2>\n<div class=\"wide\">" +
                    svgOf(chart, 960, 420) + "</div><div class=\"narrow\">" +
                    svgOf(chart, 360, 360) + "</div>\n";
        }
        html += "<h2>" + escaped(table.title) + "</h2>\n" + tableHtml(table);
    }
    return html + "</section>\n";
}

std::string settingsRow(const std::string& name, const std::string& value)
{
    return "<tr><th scope=\"row\">" + escaped(name) + "</th><td>" + escaped(value) + "</td></tr>\n";
}

std::string htmlOf(const BenchReport& report)
{
    std::string html = charts::pageBegin("Isofront benchmarks") + "<h1>Isofront benchmarks</h1>\n";
    html += "<p class=\"what\">Intensity " + std::string(nameOf(report.intensity)) +
            "; times are processor time, least of the runs, on one thread unless said "
            "otherwise.</p>\n<p>";
    for (const SuiteRun& run : report.runs)
        html += "<a href=\"#" + escaped(run.name) + "\">" + escaped(run.name) + "</a> ";
    html += "</p>\n";
    for (const SuiteRun& run : report.runs)
        html += runHtml(run);
    html += "<section><h2>Machine</h2>\n<table class=\"settings\"><tbody>\n" +
            settingsRow("Processor", report.machine.processor) +
            settingsRow("Cores", std::to_string(report.machine.cores)) +
            settingsRow("Threads used", std::to_string(report.threads)) +
            settingsRow("System", report.machine.system) +
            settingsRow("Compiler", report.machine.compiler) +
            settingsRow("Isofront", report.machine.version);
    for (const FmaRate& rate : report.machine.fma) {
        std::array<char, 64> text{};
        (void)std::snprintf(text.data(), text.size(), "%.1f GFLOP/s on one thread", rate.gigaflops);
        html += settingsRow("FMA, " + rate.instructionSet, text.data());
    }
    return html + "</tbody></table></section>\n" + charts::pageEnd();
}

} // namespace

bool BenchReport::allChecksHold() const
{
    return std::ranges::all_of(runs, [](const SuiteRun& run) {
        return std::ranges::all_of(run.result.checks, &Check::holds);
    });
}

std::string jsonOf(const BenchReport& report)
{
    Json runs = Json::array();
    for (const SuiteRun& run : report.runs) {
        Json checks = Json::array();
        for (const Check& check : run.result.checks)
            checks.push_back({{"what", check.what}, {"holds", check.holds}, {"seen", check.seen}});
        Json tables = Json::array();
        for (const Table& table : run.result.tables)
            tables.push_back(tableJson(table));
        runs.push_back(
            {{"name", run.name},
             {"question", run.question},
             {"seconds", run.seconds},
             {"notes", run.result.notes},
             {"checks", std::move(checks)},
             {"tables", std::move(tables)}});
    }
    const Json json = {
        {"format", "isofront.bench"},
        {"version", 1},
        {"intensity", nameOf(report.intensity)},
        {"threads", report.threads},
        {"machine", machineJson(report.machine)},
        {"suites", std::move(runs)}};
    return json.dump(1);
}

core::Result<void> writeBenchReport(const BenchReport& report, const std::filesystem::path& folder)
{
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error)
        return core::failure(
            core::ErrorCode::inputOutput,
            folder.string() + ": the folder can't be made: " + error.message());
    std::vector<std::pair<std::string, std::string>> files = {
        {"report.json", jsonOf(report) + "\n"}, {"report.html", htmlOf(report)}};
    for (const SuiteRun& run : report.runs)
        for (const Table& table : run.result.tables) {
            files.emplace_back(run.name + "." + table.name + ".csv", csvOf(table));
            for (const Plot& plot : table.plots)
                files.emplace_back(
                    run.name + "." + plot.name + ".svg", svgFileOf(chartOf(table, plot), 720, 400));
        }
    for (const auto& [name, content] : files)
        if (const auto written = exchange::writeFile(folder / name, content); !written)
            return tl::unexpected<core::Error>(written.error());
    return {};
}

} // namespace isofront::bench
