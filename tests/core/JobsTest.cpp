#include <isofront/core/Jobs.h>

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <numeric>
#include <vector>

namespace isofront::core {
namespace {

class JobsTest : public testing::TestWithParam<JobsBackend> {};

TEST_P(JobsTest, runsEverySubmittedJobOnceBeforeWaitReturns)
{
    const auto jobs = makeJobs(GetParam(), 3);
    std::atomic<int> runs{0};
    for (int i = 0; i < 1000; ++i)
        jobs->submit([&] { ++runs; });
    jobs->wait();
    EXPECT_EQ(runs, 1000);
}

TEST_P(JobsTest, letsJobsSubmitJobs)
{
    const auto jobs = makeJobs(GetParam(), 2);
    std::atomic<int> runs{0};
    for (int i = 0; i < 50; ++i)
        jobs->submit([&] {
            ++runs;
            jobs->submit([&] { ++runs; });
        });
    jobs->wait();
    EXPECT_EQ(runs, 100);
}

TEST_P(JobsTest, visitsEachIndexOfALoopOnce)
{
    const auto jobs = makeJobs(GetParam(), 4);
    std::vector<int> visits(10007, 0);
    jobs->parallelFor(visits.size(), [&](std::size_t i) { ++visits[i]; });
    for (const int count : visits)
        ASSERT_EQ(count, 1);
    jobs->parallelFor(0, [&](std::size_t) { FAIL(); });
}

TEST_P(JobsTest, finishesWhatWasSubmittedBeforeItGoes)
{
    std::atomic<int> runs{0};
    {
        const auto jobs = makeJobs(GetParam(), 2);
        for (int i = 0; i < 100; ++i)
            jobs->submit([&] { ++runs; });
    }
    EXPECT_EQ(runs, 100);
}

TEST_P(JobsTest, runsAsManyJobsAtOnceAsItSays)
{
    const auto jobs = makeJobs(GetParam(), 3);
    const auto together = static_cast<std::ptrdiff_t>(jobs->concurrency());
    std::latch meeting(together); // hangs if fewer run at once
    for (std::ptrdiff_t i = 0; i < together; ++i)
        jobs->submit([&] { meeting.arrive_and_wait(); });
    jobs->wait();
}

INSTANTIATE_TEST_SUITE_P(
    Backends,
    JobsTest,
    testing::Values(JobsBackend::automatic, JobsBackend::threads, JobsBackend::inlined),
    [](const auto& parameter) {
        switch (parameter.param) {
        case JobsBackend::inlined:
            return "inlined";
        case JobsBackend::threads:
            return "threads";
        default:
            return "automatic";
        }
    });

} // namespace
} // namespace isofront::core
