#pragma once

#include "isofront/bench/Table.h"

#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <vector>

namespace isofront::bench {

enum class Intensity {
    quick, ///< every suite in two seconds or so: shows the shape of each curve
    full,  ///< minutes: what defaults are chosen by
};

/// What a suite may use.
struct Context {
    Intensity intensity = Intensity::quick;
    /// Where suites run what is not timed on one thread.
    std::shared_ptr<core::Jobs> jobs;
    /// Folders with volumes, looked at by the suites that measure files; missing ones are fine.
    std::vector<std::filesystem::path> dataFolders;
    /// Tells the user what is being measured.
    std::function<void(const std::string&)> say;
    /// Looked at between measurements; a stopped suite returns what it has.
    std::stop_token stop;

    [[nodiscard]] bool isFull() const { return intensity == Intensity::full; }
    [[nodiscard]] bool isStopped() const { return stop.stop_requested(); }
    /// How often something is timed at most.
    [[nodiscard]] std::size_t runs() const { return isFull() ? 5 : 1; }
    /// One of two values, by intensity.
    template <typename T>
    [[nodiscard]] T pick(T quick, T full) const
    {
        return isFull() ? full : quick;
    }
};

/// A fact that must hold for the numbers beside it to mean anything.
struct Check {
    std::string what;
    bool holds = false;
    std::string seen; ///< the numbers it was judged by
};

struct SuiteResult {
    std::vector<Table> tables;
    std::vector<Check> checks;
    /// What a reader must know besides, in sentences: which device drew, or why nothing was
    /// measured.
    std::vector<std::string> notes;

    void check(std::string what, bool holds, std::string seen)
    {
        checks.push_back({std::move(what), holds, std::move(seen)});
    }
};

/// A benchmark: a question, and how it is answered.
///
/// To add one: write `SuiteResult runX(const Context&)` in bench/src/suites/, declare it in
/// bench/src/suites/Suites.h, and enter it in the list of bench/src/Suite.cpp.
struct Suite {
    std::string name;
    std::string question; ///< one sentence, as a user would ask
    std::function<SuiteResult(const Context&)> run;
};

/// All there are, in the order in which they run.
const std::vector<Suite>& suites();

/// Those named, in the order of `suites()`; all of them if none is named. An unknown name is a
/// usage error that lists those there are.
core::Result<std::vector<Suite>> suitesNamed(const std::vector<std::string>& names);

} // namespace isofront::bench
