#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace isofront::bench {

/// Processor time of some runs of one thing, all threads of the process together [s].
struct Timing {
    double least = 0;
    double median = 0;
    double spread = 0; ///< (greatest - least) / median
    double wall = 0;   ///< least time by the clock [s]
    std::size_t runs = 0;
};

/// Runs something up to so many times, and reports how long it took. Processor time, because a
/// machine that is shared gives any wall time.
/// @param seconds  after which no further run begins
Timing timed(const std::function<void()>& work, std::size_t runs = 5, double seconds = 2);

/// What one thread can do with one instruction set: independent fused multiply-adds of floats, as
/// many at once as the units take.
struct FmaRate {
    std::string instructionSet; ///< "AVX3", "AVX2", ... as Highway names them
    double gigaflops = 0;       ///< two operations each
};

/// Measures each instruction set that the machine has and the compiler built, best first. Takes
/// about 50 ms for each. Thread: one at a time.
std::vector<FmaRate> fmaRates();

/// Runs something with only the named instruction set allowed, whatever the machine has: the SIMD
/// code of all modules obeys. The name must be one of `fmaRates()`. Thread: one at a time, and none
/// that samples fields meanwhile.
void withInstructionSet(const std::string& name, const std::function<void()>& work);

/// Who measured: what a reader needs to compare with a machine of their own.
struct Machine {
    std::string processor;
    std::size_t cores = 0; ///< that this process may use
    std::string system;
    std::string compiler;
    std::string version; ///< of Isofront
    std::vector<FmaRate> fma;
};

Machine thisMachine();

} // namespace isofront::bench
