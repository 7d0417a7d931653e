#pragma once

#include "isofront/bench/Suite.h"

#include <isofront/core/Box.h>
#include <isofront/core/Jobs.h>
#include <isofront/core/Result.h>
#include <isofront/surface/TriangleMesh.h>
#include <isofront/voxels/ChunkStore.h>
#include <isofront/voxels/TriangleModel.h>
#include <isofront/voxels/Voxelization.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

namespace isofront::bench {

/// A mesh of the folder `meshes` beside one of the context's data folders; nothing if it isn't
/// there or can't be read.
std::optional<voxels::TriangleModel> modelFile(const Context& context, const std::string& name);
/// The scan that papers show: 871 414 triangles.
inline constexpr const char* kDragon = "stanford_dragon_871k.ply.gz";

/// A sphere of radius 1 with hills, of `4 rows^2` triangles: what there is to look at without a
/// file.
voxels::TriangleModel hills(std::uint32_t rows);
/// Blocks of houses on the unit square, all of one kind, of different heights.
/// @param height  of the lowest, as a share of a block's edge; the highest are five times as high
voxels::TriangleModel city(int blocks, double height = 1);

voxels::TriangleModel modelOf(const surface::TriangleMesh& mesh);
core::Box boundsOf(const voxels::TriangleModel& model);
double areaOf(const voxels::TriangleModel& model);

/// Says what is done, then how far it has come, in steps of a tenth. Thread: any, one at a time.
std::function<void(double)> tenthsOf(const Context& context, std::string what);

/// True as soon as a context is to stop: what voxelising looks at.
class Cancellation {
public:
    explicit Cancellation(const Context& context)
        : _callback(context.stop, [this] { _isCancelled = true; })
    {
    }
    Cancellation(const Cancellation&) = delete;
    Cancellation& operator=(const Cancellation&) = delete;

    [[nodiscard]] const std::atomic<bool>* flag() const { return &_isCancelled; }

private:
    std::atomic<bool> _isCancelled = false;
    std::stop_callback<std::function<void()>> _callback;
};

/// A model in voxels, in memory.
core::Result<std::shared_ptr<voxels::ChunkStore>> inMemory(
    const Context& context,
    const std::string& name,
    const voxels::TriangleModel& model,
    std::uint32_t resolution);

/// All bytes of a store's chunks.
std::uint64_t bytesOf(const voxels::ChunkStore& store);

/// Jobs that wait until they are told to run, so that choosing can be timed without loading.
class WaitingJobs : public core::Jobs {
public:
    void submit(std::function<void()> job) override { _jobs.push_back(std::move(job)); }
    void parallelFor(std::size_t count, const std::function<void(std::size_t)>& body) override
    {
        for (std::size_t i = 0; i < count; ++i)
            body(i);
    }
    void wait() override
    {
        for (const auto& job : std::exchange(_jobs, {}))
            job();
    }
    [[nodiscard]] std::size_t concurrency() const override { return 1; }

private:
    std::vector<std::function<void()>> _jobs;
};

} // namespace isofront::bench
