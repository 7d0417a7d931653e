#include "Console.h"

#include <nlohmann/json.hpp>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <thread>
#include <utility>

namespace isofront::cli {

namespace {

constexpr auto kTerminalInterval = std::chrono::milliseconds(100);
constexpr auto kLogInterval = std::chrono::seconds(5);

/// A line of progress stands on the terminal and waits to be rewritten.
bool lineIsOpen = false;

void eraseLine()
{
    if (lineIsOpen)
        std::fprintf(stderr, "\r\033[K");
    lineIsOpen = false;
}

bool isTerminal()
{
    static const bool terminal = isatty(STDERR_FILENO) == 1;
    return terminal;
}

} // namespace

void Progress::show(const std::string& what, double share)
{
    if (_quiet)
        return;
    const auto now = std::chrono::steady_clock::now();
    if (now - _last < (isTerminal() ? std::chrono::steady_clock::duration(kTerminalInterval)
                                    : std::chrono::steady_clock::duration(kLogInterval)))
        return;
    // what is divided into parts of guessed sizes may seem to go back
    _share = what == _what ? std::max(_share, share) : share;
    _what = what;
    share = _share;
    const bool isFirst = _last == std::chrono::steady_clock::time_point{};
    _last = now;
    if (isFirst && !isTerminal())
        return; // short work needs no line in a log
    std::string text = what;
    if (share >= 0)
        text += " " + std::to_string(static_cast<int>(100 * share)) + " %";
    if (isTerminal())
        std::fprintf(stderr, "\r\033[K%s", text.c_str());
    else
        std::fprintf(stderr, "%s\n", text.c_str());
    lineIsOpen = isTerminal();
    std::fflush(stderr);
}

void Progress::finish()
{
    eraseLine();
}

void Progress::say(const std::string& line)
{
    finish();
    if (!_quiet)
        std::fprintf(stderr, "%s\n", line.c_str());
}

std::stop_token interruptions()
{
    // Signals are taken by a thread of its own, where anything may be done about them.
    static std::stop_source source;
    static const bool started = [] {
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, SIGINT);
        sigaddset(&signals, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &signals, nullptr);
        std::thread([signals] {
            int number = 0;
            sigwait(&signals, &number);
            source.request_stop();
            sigwait(&signals, &number);
            std::_Exit(static_cast<int>(core::ErrorCode::interrupted));
        }).detach();
        return true;
    }();
    static_cast<void>(started);
    return source.get_token();
}

EndedAtOnce::EndedAtOnce(const std::stop_token& stop, std::string line)
    : _ending(stop, [line = std::move(line)] {
          std::_Exit(report({core::ErrorCode::interrupted, line}));
      })
{
}

int report(const core::Error& error)
{
    eraseLine();
    std::string line = error.message;
    for (char& c : line)
        if (c == '\n')
            c = ' ';
    std::fprintf(stderr, "isofront: %s\n", line.c_str());
    return static_cast<int>(error.code);
}

void print(const nlohmann::ordered_json& json)
{
    std::cout << json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n'
              << std::flush;
}

int finishOutput(int exitCode)
{
    std::cout.flush();
    const bool lost = !std::cout || std::fflush(stdout) != 0 || std::ferror(stdout) != 0;
    if (exitCode != 0 || !lost)
        return exitCode;
    return report(
        {core::ErrorCode::inputOutput, "standard output can't be written: is the disk full?"});
}

std::string brief(double number)
{
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", number);
    return text.data();
}

std::string grouped(std::uint64_t number)
{
    std::string digits = std::to_string(number);
    for (std::size_t i = digits.size(); i > 3;) {
        i -= 3;
        digits.insert(i, ",");
    }
    return digits;
}

} // namespace isofront::cli
