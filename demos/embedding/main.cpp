// Embeds Isofront in a program of one's own: a canyon, streamed to a host that keeps its meshes.
//
// The host stands for whatever uses the triangles: a renderer, a physics engine, a client far away.
// The lines between the snippet marks are those of README.md; a test compares them.
#include <isofront/fields/Terrain.h>
#include <isofront/surface/Surface.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <memory>
#include <thread>
#include <unordered_map>

namespace {

using isofront::surface::CellId;
using isofront::surface::CellIdHash;

/// Holds the meshes on show. They are shared with the surface, and never change.
class Host {
public:
    using Mesh = std::shared_ptr<const isofront::extractor::CellMesh>;

    void upload(const CellId& id, const Mesh& mesh)
    {
        _meshes[id] = mesh;
        _triangles += mesh->triangleCount();
        _bytes += mesh->bytes();
    }
    void release(const CellId& id)
    {
        const auto found = _meshes.find(id);
        _triangles -= found->second->triangleCount();
        _bytes -= found->second->bytes();
        _meshes.erase(found);
    }

    [[nodiscard]] std::size_t cells() const { return _meshes.size(); }
    [[nodiscard]] std::size_t triangles() const { return _triangles; }
    [[nodiscard]] std::size_t bytes() const { return _bytes; }

private:
    std::unordered_map<CellId, Mesh, CellIdHash> _meshes;
    std::size_t _triangles = 0;
    std::size_t _bytes = 0;
};

/// From the rim of the canyon, looking along it.
isofront::hierarchy::View someView()
{
    isofront::hierarchy::View view;
    view.eye = {0.0, 0.0, 1200.0};
    view.forward = {0.3, 1.0, -0.4};
    view.width = 640;
    view.height = 360;
    return view;
}

} // namespace

int main()
{
    Host host;
    const isofront::hierarchy::View view = someView();

    // [snippet]
    auto field = isofront::fields::terrain({.preset = "canyon", .seed = 7});
    isofront::surface::Surface surface(field, {.origin = glm::dvec3(-8192.0), .edge = 16384.0});

    while (!surface.isSettled()) {
        const auto delta = surface.update(view, {.milliseconds = 2.0}); // never waits
        for (const auto& id : delta.removed)
            host.release(id);
        for (const auto& cell : delta.added) // after both loops the mesh has no crack
            host.upload(cell.id, cell.mesh());
        // [/snippet]
        // A program would draw its frame here; this one leaves the processor to the extraction.
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }

    const isofront::surface::SurfaceStats stats = surface.stats();
    std::printf(
        "the host holds %zu cells, %zu triangles, %zu bytes, after %llu deltas\n",
        host.cells(),
        host.triangles(),
        host.bytes(),
        static_cast<unsigned long long>(stats.deltas));
    std::printf(
        "%llu cells were sampled; %llu were proved empty and never sampled\n",
        static_cast<unsigned long long>(stats.cellsExtracted),
        static_cast<unsigned long long>(stats.cellsSkipped));
    return host.triangles() == stats.triangles ? 0 : 1;
}
