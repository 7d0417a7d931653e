#include "isofront/bench/Timing.h"

#include <sys/utsname.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <fstream>
#include <thread>

namespace isofront::bench {

namespace {

double processorSeconds()
{
    timespec now{};
    (void)::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

std::string processorName()
{
    std::ifstream file("/proc/cpuinfo");
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name"))
            if (const std::size_t at = line.find(": "); at != std::string::npos)
                return line.substr(at + 2);
    return "unknown";
}

} // namespace

Timing timed(const std::function<void()>& work, std::size_t runs, double seconds)
{
    using Clock = std::chrono::steady_clock;
    Timing timing;
    std::vector<double> all;
    const auto begin = Clock::now();
    for (std::size_t i = 0; i < std::max<std::size_t>(runs, 1); ++i) {
        const auto wallStart = Clock::now();
        const double start = processorSeconds();
        work();
        all.push_back(processorSeconds() - start);
        const double wall = std::chrono::duration<double>(Clock::now() - wallStart).count();
        timing.wall = i == 0 ? wall : std::min(timing.wall, wall);
        if (std::chrono::duration<double>(Clock::now() - begin).count() > seconds)
            break;
    }
    std::ranges::sort(all);
    timing.runs = all.size();
    timing.least = all.front();
    timing.median = all[all.size() / 2];
    timing.spread = timing.median > 0 ? (all.back() - all.front()) / timing.median : 0;
    return timing;
}

Machine thisMachine()
{
    Machine machine;
    machine.processor = processorName();
    machine.cores = std::max(1U, std::thread::hardware_concurrency());
    utsname name{};
    if (::uname(&name) == 0)
        machine.system = std::string(name.sysname) + " " + name.release + " " + name.machine;
    machine.compiler = __VERSION__;
#ifdef __clang__
    machine.compiler = "Clang " + machine.compiler;
#elif defined(__GNUC__)
    machine.compiler = "GCC " + machine.compiler;
#endif
    machine.version = ISOFRONT_VERSION;
    machine.fma = fmaRates();
    return machine;
}

} // namespace isofront::bench
