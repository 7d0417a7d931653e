// The machine's own speed limit, measured in the run that it is compared with: sixteen independent
// chains of fused multiply-adds, more than latency times units of any processor so far.

#include "isofront/bench/Timing.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "FmaProbe.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::bench::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// @return operations done, and in `sink` what they came to, so that none is left out
double fuseOn(std::size_t rounds, float* sink)
{
    const hn::ScalableTag<float> d;
    using V = hn::Vec<decltype(d)>;
    const V factor = hn::Set(d, 0.9999999F);
    const V term = hn::Set(d, 1e-7F);
    // each chain begins elsewhere, and where is not known before: a compiler would merge equal ones
    const auto start = [&](float chain) { return hn::Set(d, *sink + chain); };
    V a0 = start(0), a1 = start(1), a2 = start(2), a3 = start(3);
    V a4 = start(4), a5 = start(5), a6 = start(6), a7 = start(7);
    V b0 = start(8), b1 = start(9), b2 = start(10), b3 = start(11);
    V b4 = start(12), b5 = start(13), b6 = start(14), b7 = start(15);
    for (std::size_t i = 0; i < rounds; ++i) {
        a0 = hn::MulAdd(a0, factor, term);
        a1 = hn::MulAdd(a1, factor, term);
        a2 = hn::MulAdd(a2, factor, term);
        a3 = hn::MulAdd(a3, factor, term);
        a4 = hn::MulAdd(a4, factor, term);
        a5 = hn::MulAdd(a5, factor, term);
        a6 = hn::MulAdd(a6, factor, term);
        a7 = hn::MulAdd(a7, factor, term);
        b0 = hn::MulAdd(b0, factor, term);
        b1 = hn::MulAdd(b1, factor, term);
        b2 = hn::MulAdd(b2, factor, term);
        b3 = hn::MulAdd(b3, factor, term);
        b4 = hn::MulAdd(b4, factor, term);
        b5 = hn::MulAdd(b5, factor, term);
        b6 = hn::MulAdd(b6, factor, term);
        b7 = hn::MulAdd(b7, factor, term);
    }
    const V low = hn::Add(
        hn::Add(hn::Add(a0, a1), hn::Add(a2, a3)), hn::Add(hn::Add(a4, a5), hn::Add(a6, a7)));
    const V high = hn::Add(
        hn::Add(hn::Add(b0, b1), hn::Add(b2, b3)), hn::Add(hn::Add(b4, b5), hn::Add(b6, b7)));
    *sink = hn::GetLane(hn::SumOfLanes(d, hn::Add(low, high)));
    return 2.0 * 16.0 * static_cast<double>(rounds) * static_cast<double>(hn::Lanes(d));
}

} // namespace isofront::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::bench {

HWY_EXPORT(fuseOn);

std::vector<FmaRate> fmaRates()
{
    std::vector<FmaRate> rates;
    for (const auto target : hwy::SupportedAndGeneratedTargets()) {
        hwy::SetSupportedTargetsForTest(target);
        float sink = 0;
        double operations = 0;
        const std::size_t rounds = 2'000'000;
        const Timing timing =
            timed([&] { operations = HWY_DYNAMIC_DISPATCH(fuseOn)(rounds, &sink); });
        // each chain falls towards 1 from where it began: a wrong result would not
        if (sink > 0 && timing.least > 0)
            rates.push_back({hwy::TargetName(target), operations / timing.least * 1e-9});
    }
    hwy::SetSupportedTargetsForTest(0);
    return rates;
}

void withInstructionSet(const std::string& name, const std::function<void()>& work)
{
    for (const auto target : hwy::SupportedAndGeneratedTargets())
        if (name == hwy::TargetName(target))
            hwy::SetSupportedTargetsForTest(target);
    work();
    hwy::SetSupportedTargetsForTest(0);
}

} // namespace isofront::bench
#endif
