#include "AssemblyLine.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <shared_mutex>
#include <thread>
#include <utility>
#include <vector>

namespace isofront::surface {

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start)
{
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Cells that go all the way together.
struct Chunk {
    std::size_t first = 0;
    std::vector<JoinedCell> cells;
};
using ChunkPointer = std::unique_ptr<Chunk>;

class AssemblyLine {
public:
    AssemblyLine(
        std::size_t cells,
        int latticeSize,
        const AssemblySteps& steps,
        MeshJoiner& joiner,
        TriangleMesh& mesh)
        : _cells(cells), _steps(steps), _joiner(joiner), _mesh(mesh)
    {
        // about as many triangles whatever the lattice, and less than a cache full
        const auto n = static_cast<std::size_t>(latticeSize);
        _chunkSize = std::max<std::size_t>(1, 256 / (n * n));
    }

    Assembled run(core::Jobs& jobs)
    {
        jobs.parallelFor(jobs.concurrency(), [this](std::size_t) { work(); });
        if (_thrown)
            std::rethrow_exception(_thrown);
        return std::move(_result);
    }

private:
    /// What each thread does until there is nothing left. Where memory runs out, the others, who
    /// would wait for this one's cells, end as well.
    void work()
    {
        try {
            assembleWhatIsLeft();
        } catch (...) {
            const std::lock_guard lock(_mutex);
            _thrown = std::current_exception();
            _result.error = core::Error{core::ErrorCode::resourceLimit, "out of memory"};
            _moved.notify_all();
        }
    }

    void assembleWhatIsLeft()
    {
        core::Box bounds;
        double seconds = 0;
        std::vector<ChunkPointer> chunks;
        while (ChunkPointer chunk = next(std::move(chunks))) {
            for (std::size_t i = 0; i < chunk->cells.size(); ++i)
                _steps.extract(chunk->first + i, chunk->cells[i]);
            const auto start = Clock::now();
            chunks = numbered(std::move(chunk));
            {
                const std::shared_lock stays(_room);
                for (const ChunkPointer& ready : chunks)
                    for (const JoinedCell& cell : ready->cells)
                        _joiner.write(cell, _mesh, bounds);
            }
            seconds += secondsSince(start);
        }
        const std::lock_guard lock(_mutex);
        _result.seconds += seconds;
        if (!bounds.isEmpty()) {
            _mesh.bounds.include(bounds.low);
            _mesh.bounds.include(bounds.high);
        }
    }

    /// The cells that are to be extracted next; null if there are none left, or after an error.
    /// @param done  chunks whose memory may be used again
    ChunkPointer next(std::vector<ChunkPointer> done)
    {
        std::unique_lock lock(_mutex);
        for (ChunkPointer& chunk : done)
            _idle.push_back(std::move(chunk));
        if (_steps.progress && std::this_thread::get_id() == _caller)
            _steps.progress(_numbered);
        // where one chunk takes long, memory must not grow with what waits for it
        _moved.wait(lock, [this] { return _waiting.size() < kMostWaiting || _result.error; });
        if (_begun >= _cells || _result.error)
            return nullptr;
        ChunkPointer chunk;
        if (_idle.empty()) {
            chunk = std::make_unique<Chunk>();
        } else {
            chunk = std::move(_idle.back());
            _idle.pop_back();
        }
        chunk->first = _begun;
        chunk->cells.resize(std::min(_chunkSize, _cells - _begun));
        _begun += chunk->cells.size();
        return chunk;
    }

    /// Numbers a chunk, and those that have waited for it, if all before it have been numbered.
    /// @return what may be written now
    std::vector<ChunkPointer> numbered(ChunkPointer chunk)
    {
        const std::lock_guard lock(_mutex);
        _waiting.push_back(std::move(chunk));
        std::vector<ChunkPointer> ready;
        for (auto turn = findTurn(); turn != _waiting.end() && !_result.error; turn = findTurn()) {
            ready.push_back(std::move(*turn));
            _waiting.erase(turn);
            number(*ready.back());
        }
        if (_result.error)
            ready.clear();
        if (!ready.empty() || _result.error)
            _moved.notify_all();
        return ready;
    }

    std::vector<ChunkPointer>::iterator findTurn()
    {
        return std::ranges::find(
            _waiting, _numbered, [](const ChunkPointer& chunk) { return chunk->first; });
    }

    void number(Chunk& chunk)
    {
        for (JoinedCell& cell : chunk.cells) {
            _steps.count(cell);
            if (!_joiner.number(cell)) {
                _result.error = core::Error{
                    core::ErrorCode::resourceLimit,
                    "the mesh has more than 4294967294 vertices: choose a larger spacing or error"};
                return;
            }
        }
        _numbered += chunk.cells.size();
        if (_joiner.fits(_mesh)) {
            _joiner.setSizes(_mesh);
        } else {
            const std::lock_guard moves(_room); // nobody writes meanwhile
            _joiner.setSizes(_mesh);
        }
        _result.error = _steps.check(_numbered, bytesOf(_mesh) + _joiner.bytes());
    }

    static std::size_t bytesOf(const TriangleMesh& mesh)
    {
        return mesh.positions.size() * sizeof(glm::dvec3) +
               mesh.normals.size() * sizeof(glm::vec3) +
               mesh.attributes.size() * sizeof(std::uint32_t) +
               mesh.indices.size() * sizeof(std::uint32_t);
    }

    static constexpr std::size_t kMostWaiting = 32;

    std::size_t _cells;
    std::size_t _chunkSize = 1;
    const AssemblySteps& _steps;
    MeshJoiner& _joiner;
    TriangleMesh& _mesh;
    const std::thread::id _caller = std::this_thread::get_id();

    std::shared_mutex _room; ///< shared by those who write; to be had alone to move the mesh
    std::mutex _mutex;       ///< of all below, and of numbering
    std::condition_variable _moved;
    std::size_t _begun = 0;    ///< cells
    std::size_t _numbered = 0; ///< cells
    std::vector<ChunkPointer> _waiting;
    std::vector<ChunkPointer> _idle;
    std::exception_ptr _thrown;
    Assembled _result;
};

} // namespace

Assembled assemble(
    std::size_t cells,
    int latticeSize,
    core::Jobs& jobs,
    const AssemblySteps& steps,
    MeshJoiner& joiner,
    TriangleMesh& mesh)
{
    return AssemblyLine(cells, latticeSize, steps, joiner, mesh).run(jobs);
}

} // namespace isofront::surface
