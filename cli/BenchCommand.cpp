#include "Arguments.h"
#include "Console.h"

#include <isofront/bench/Report.h>
#include <isofront/bench/Suite.h>

#include <nlohmann/json.hpp>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>
#include <system_error>

namespace isofront::cli {

namespace {

namespace fs = std::filesystem;
using core::ErrorCode;

struct BenchArguments {
    std::vector<std::string> suites;
    bool list = false;
    bool quick = false;
    bool full = false;
    std::string out = "bench";
    std::vector<std::string> data;
    std::size_t threads = 0;
    bool json = false;
    bool quiet = false;
};

int list(const BenchArguments& arguments)
{
    if (arguments.json) {
        nlohmann::ordered_json json = nlohmann::ordered_json::array();
        for (const bench::Suite& suite : bench::suites())
            json.push_back({{"name", suite.name}, {"question", suite.question}});
        print(json);
        return 0;
    }
    std::size_t width = 0;
    for (const bench::Suite& suite : bench::suites())
        width = std::max(width, suite.name.size());
    for (const bench::Suite& suite : bench::suites())
        std::cout << suite.name << std::string(width + 2 - suite.name.size(), ' ') << suite.question
                  << '\n';
    return 0;
}

/// Folders with volumes: those given, that of the tests, and that of a clone we run in.
std::vector<fs::path> dataFolders(const BenchArguments& arguments)
{
    std::vector<fs::path> folders(arguments.data.begin(), arguments.data.end());
    // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing changes the environment
    if (const char* const shared = std::getenv("ISOFRONT_TEST_DATA"); shared != nullptr)
        folders.push_back(fs::path(shared) / "volumes");
    folders.emplace_back("data/volumes");
    return folders;
}

int bench(const BenchArguments& arguments)
{
    if (arguments.list)
        return list(arguments);
    if (arguments.quick && arguments.full)
        return report({ErrorCode::usage, "--quick and --full: give one of them"});
    for (const std::string& folder : arguments.data)
        if (std::error_code ignored; !fs::is_directory(folder, ignored))
            return report(
                {ErrorCode::inputOutput, "--data " + folder + ": there is no such folder"});
    const auto chosen = bench::suitesNamed(arguments.suites);
    if (!chosen)
        return report(chosen.error());
    std::error_code error;
    fs::create_directories(arguments.out, error);
    if (error)
        return report(
            {ErrorCode::inputOutput,
             "--out " + arguments.out + ": the folder can't be made: " + error.message()});

    Progress progress(arguments.quiet);
    bench::Context context;
    context.intensity = arguments.full ? bench::Intensity::full : bench::Intensity::quick;
    context.jobs = core::makeJobs(core::JobsBackend::automatic, arguments.threads);
    context.dataFolders = dataFolders(arguments);
    context.stop = interruptions();

    bench::BenchReport all;
    all.machine = bench::thisMachine();
    all.intensity = context.intensity;
    all.threads = context.jobs->concurrency();
    for (std::size_t i = 0; i < chosen->size(); ++i) {
        const bench::Suite& suite = (*chosen)[i];
        context.say = [&](const std::string& what) {
            // what is said may end in a share of its own
            progress.show(
                "suite " + std::to_string(i + 1) + " of " + std::to_string(chosen->size()) + ", " +
                    suite.name + ": " + what,
                -1);
        };
        context.say("begins");
        const auto start = std::chrono::steady_clock::now();
        bench::SuiteRun run{suite.name, suite.question, 0, suite.run(context)};
        if (context.isStopped())
            return report({ErrorCode::interrupted, "interrupted; nothing was written"});
        run.seconds =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        progress.finish();
        for (const std::string& note : run.result.notes)
            progress.say("note: " + suite.name + ": " + note);
        for (const bench::Check& check : run.result.checks)
            if (!check.holds)
                progress.say(
                    "warning: " + suite.name + ": it does not hold that " + check.what + ": " +
                    check.seen);
        all.runs.push_back(std::move(run));
    }
    if (const auto written = bench::writeBenchReport(all, arguments.out); !written)
        return report(written.error());
    progress.say((fs::path(arguments.out) / "report.html").string() + " shows the results");
    if (arguments.json)
        print(nlohmann::ordered_json::parse(bench::jsonOf(all)));
    if (!all.allChecksHold())
        return report(
            {ErrorCode::badData,
             "a check of the benchmarks does not hold; " +
                 (fs::path(arguments.out) / "report.html").string() + " says which"});
    return 0;
}

} // namespace

Action addBench(CLI::App& app)
{
    auto arguments = std::make_shared<BenchArguments>();
    CLI::App* command = app.add_subcommand(
        "bench", "Measure error, time and memory, and write tables and plots of them");
    command->add_option("SUITE", arguments->suites, "which suites to run; all of them if none");
    command->add_flag("--list", arguments->list, "say which suites there are, and run none");
    command->add_flag("--quick", arguments->quick, "seconds a suite, coarse curves (default)");
    command->add_flag("--full", arguments->full, "minutes a suite: what defaults are chosen by");
    command
        ->add_option("--out", arguments->out, "folder for report.html, report.json, .csv and .svg")
        ->capture_default_str();
    command->add_option(
        "--data",
        arguments->data,
        "folders with volumes, beside $ISOFRONT_TEST_DATA/volumes and data/volumes");
    command->add_option("--threads", arguments->threads, "for what is not timed; 0: each core")
        ->check(CLI::Range(0, 1024))
        ->capture_default_str();
    command->add_flag("--json", arguments->json, "one JSON object on standard output");
    command->add_flag("-q,--quiet", arguments->quiet, "no progress and remarks");
    command->footer(
        "Every suite checks the answers that it times; exit code 3 if a check does not hold.\n"
        "Example: isofront bench accuracy --full --out bench");
    return [arguments] { return bench(*arguments); };
}

} // namespace isofront::cli
