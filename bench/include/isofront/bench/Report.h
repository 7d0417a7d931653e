#pragma once

#include "isofront/bench/Suite.h"
#include "isofront/bench/Timing.h"

#include <isofront/core/Result.h>

#include <filesystem>
#include <string>
#include <vector>

namespace isofront::bench {

/// A suite that has run.
struct SuiteRun {
    std::string name;
    std::string question;
    double seconds = 0; ///< that it took, by the clock
    SuiteResult result;
};

struct BenchReport {
    Machine machine;
    Intensity intensity = Intensity::quick;
    std::size_t threads = 1;
    std::vector<SuiteRun> runs;

    [[nodiscard]] bool allChecksHold() const;
};

/// The report as one JSON object; docs/bench-json.md describes it.
std::string jsonOf(const BenchReport& report);

/// Writes report.json, report.html (one page, no scripts, nothing from the network),
/// SUITE.TABLE.csv for each table and SUITE.PLOT.svg for each plot into a folder, each whole or not
/// at all. The folder is made if it is missing.
/// Errors: inputOutput.
core::Result<void> writeBenchReport(const BenchReport& report, const std::filesystem::path& folder);

} // namespace isofront::bench
