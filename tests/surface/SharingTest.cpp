// What a surface shares with others: the jobs, and the order in which they do what is asked.

#include "LiveSurfaceFixture.h"

#include <atomic>
#include <functional>
#include <mutex>
#include <set>

namespace isofront::surface {
namespace {

/// The hills of a field that answers only as often as it is allowed to.
class GatedHills final : public fields::Field {
public:
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        ++waiting;
        for (int left = answers; left == 0 || !answers.compare_exchange_weak(left, left - 1);
             left = answers)
            std::this_thread::sleep_for(std::chrono::microseconds(100));
        --waiting;
        Hills().sample(batch, values);
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return Hills().bounds(box, radius);
    }
    [[nodiscard]] double differenceStep(double) const override { return 1e-4; }

    mutable std::atomic<int> answers{0};
    mutable std::atomic<int> waiting{0};
};

/// Lets jobs that wait for an answer come to their end, however a test ends.
struct OpenAtLast {
    GatedHills& field;
    ~OpenAtLast() { field.answers = 1'000'000; }
};

TEST(SharedJobs, areLetGoByTheThreadThatOwnsTheSurface)
{
    // Jobs that keep what they have run for a while, as any may, and that notice who ends them.
    struct Ends {
        std::atomic<int> byOwner{0};
        std::atomic<int> byWorker{0};
    };
    class Lingering final : public core::Jobs {
    public:
        explicit Lingering(Ends& ends) : _ends(ends) {}
        ~Lingering() override
        {
            (std::this_thread::get_id() == _owner ? _ends.byOwner : _ends.byWorker)++;
            for (std::thread& thread : _threads)
                thread.get_id() == std::this_thread::get_id() ? thread.detach() : thread.join();
        }
        void submit(std::function<void()> job) override
        {
            const std::lock_guard lock(_mutex);
            _threads.emplace_back([job = std::move(job)]() mutable {
                job();
                std::this_thread::sleep_for(std::chrono::milliseconds(20));
                job = nullptr;
            });
        }
        void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
        {
            for (std::size_t i = 0; i < count; ++i)
                body(i);
        }
        void wait() override {}
        [[nodiscard]] std::size_t concurrency() const override { return 2; }

    private:
        Ends& _ends;
        std::thread::id _owner = std::this_thread::get_id();
        std::mutex _mutex;
        std::vector<std::thread> _threads;
    };
    Ends ends;
    {
        SurfaceOptions options = smallOptions();
        options.maxLevel = 6;
        Surface surface(std::make_shared<Hills>(), {}, options, std::make_shared<Lingering>(ends));
        const hierarchy::View view = viewFrom({0.4, 0.3, 0.7});
        surface.settle(view);
        surface.setIsovalue(0.01);
        surface.update(view); // and it goes in the middle of the change
    }
    for (int i = 0; i < 1000 && ends.byOwner + ends.byWorker == 0; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    EXPECT_EQ(ends.byOwner, 1);
    EXPECT_EQ(ends.byWorker, 0) << "a job would wait for itself";
}

TEST(SharedJobs, serveAllSurfacesInTurn)
{
    for (const auto backend : {core::JobsBackend::threads, core::JobsBackend::automatic}) {
        const auto jobs = jobsOf(backend, 1);
        const auto field = std::make_shared<GatedHills>();
        SurfaceOptions options = smallOptions();
        Surface busy(field, {}, options, jobs);
        const hierarchy::View view = viewFrom({0.4, 0.3, 0.6});
        const OpenAtLast opening{*field};
        for (int i = 0; i < 1000 && busy.stats().pendingCells < 300; ++i)
            busy.update(view, {.milliseconds = 20});
        ASSERT_GE(busy.stats().pendingCells, 300U);

        // How many answers the busy one is given, one at a time, until the other has its delta.
        int given = 0;
        const auto deltaOf = [&](Surface& surface) {
            for (;;) {
                const Delta delta = surface.update(view, {.milliseconds = 1000});
                if (!delta.isEmpty() || given > 10'000)
                    return delta;
                if (field->waiting > 0 && field->answers == 0) {
                    field->answers = 1;
                    ++given;
                }
                std::this_thread::sleep_for(std::chrono::microseconds(100));
            }
        };
        options.maxLevel = 3;
        Surface other(std::make_shared<Hills>(), {}, options, jobs);
        EXPECT_FALSE(deltaOf(other).isEmpty());
        EXPECT_GT(busy.stats().pendingCells, 100U) << "it had to wait for all of the other's work";
        // a whole surface takes its turns as well, and leaves others theirs
        other.setIsovalue(0.01);
        EXPECT_FALSE(deltaOf(other).isEmpty());
        EXPECT_GT(busy.stats().pendingCells, 50U);
    }
}

TEST(SurfaceBounds, areAskedForOnceOfEachDiamond)
{
    // by the thread that updates; workers ask for those of cells, which are other boxes
    class Noting final : public fields::Field {
    public:
        void sample(const fields::SampleBatch& batch, std::span<float> values) const override
        {
            Hills().sample(batch, values);
        }
        [[nodiscard]] core::Interval
        bounds(const core::Box& box, core::Interval radius) const override
        {
            if (std::this_thread::get_id() == _owner) {
                ++asked;
                different.insert(
                    {box.low.x, box.low.y, box.low.z, box.high.x, box.high.y, box.high.z});
            }
            return Hills().bounds(box, radius);
        }
        [[nodiscard]] double differenceStep(double) const override { return 1e-4; }

        mutable std::size_t asked = 0;
        mutable std::set<std::array<double, 6>> different;

    private:
        std::thread::id _owner = std::this_thread::get_id();
    };
    const auto field = std::make_shared<Noting>();
    SurfaceOptions options = smallOptions();
    options.pixelError = 4;
    Surface surface(field, {}, options, jobsOf(core::JobsBackend::threads));
    Host host;
    DetailSettings detail;
    settleInto(surface, host, viewFrom({0.4, 0.3, 0.7}));
    const std::size_t first = field->asked;
    EXPECT_GT(first, 100U);
    surface.setIsovalue(0.02);
    settleInto(surface, host, viewFrom({0.4, 0.3, 0.7}));
    settleInto(surface, host, viewFrom({0.7, 0.6, 0.6}));
    detail.focus.push_back(
        {.box = {glm::dvec3(0.2), glm::dvec3(0.3)}, .radius = 0.2, .error = 0.001});
    surface.setDetail(5, detail);
    settleInto(surface, host, viewFrom({0.7, 0.6, 0.6}));
    surface.setIsovalue(0);
    settleInto(surface, host, viewFrom({0.4, 0.3, 0.7}));
    EXPECT_GT(field->asked, first);
    EXPECT_EQ(field->asked, field->different.size());
}

} // namespace
} // namespace isofront::surface
