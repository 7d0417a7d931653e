#pragma once

#include <isofront/core/Result.h>

#include <nlohmann/json_fwd.hpp>

#include <chrono>
#include <functional>
#include <stop_token>
#include <string>

namespace isofront::cli {

/// Progress and remarks on standard error: a line that is rewritten on a terminal, otherwise a
/// plain line every few seconds, so that a log stays readable.
class Progress {
public:
    explicit Progress(bool quiet) : _quiet(quiet) {}
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;
    ~Progress() { finish(); }

    /// @param share  in [0, 1]; negative if it isn't known. Of the same work it doesn't go back.
    void show(const std::string& what, double share);
    /// Ends the line that is being rewritten, if there is one.
    void finish();
    /// One line that stays.
    void say(const std::string& line);

private:
    bool _quiet;
    std::string _what;
    double _share = -1;
    std::chrono::steady_clock::time_point _last{};
};

/// A token that is stopped when the user interrupts the process (SIGINT, SIGTERM). A second
/// interruption ends the process at once.
std::stop_token interruptions();

/// What is said where a picture was to be made.
inline constexpr const char* kNoPicture = "interrupted; no picture was written";

/// While it lives, an interruption ends the process at once, with this line: for work that can't be
/// stopped, as a large picture's on a device, and has nothing on the disk yet.
class EndedAtOnce {
public:
    EndedAtOnce(const std::stop_token& stop, std::string line);

private:
    std::stop_callback<std::function<void()>> _ending;
};

/// Prints the one line of a failure, and turns it into the process's exit code.
int report(const core::Error& error);

/// Prints a JSON object to standard output, and nothing else there.
void print(const nlohmann::ordered_json& json);

/// To be called last: turns success into a failure if standard output took not all that was
/// printed.
int finishOutput(int exitCode);

/// A number as short as people write it: 0.5, 300, 1e-09.
std::string brief(double number);

/// Digits that people read: 1234567 as "1,234,567".
std::string grouped(std::uint64_t number);

} // namespace isofront::cli
