// After P. Cignoni, C. Rocchini and R. Scopigno, "Metro: measuring error on simplified surfaces"
// (1998): distances from points spread evenly by area, both ways. Differs: one side is the field
// itself, so that the reference has no error of its own.

#include "isofront/bench/DistanceMeasure.h"

#include "isofront/bench/Topology.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace isofront::bench {

namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr std::size_t kChunk = 1024;

/// Runs `body(i)` for all i in chunks of jobs.
void forEach(core::Jobs& jobs, std::size_t count, const std::function<void(std::size_t)>& body)
{
    jobs.parallelFor((count + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        const std::size_t end = std::min(count, (chunk + 1) * kChunk);
        for (std::size_t i = chunk * kChunk; i < end; ++i)
            body(i);
    });
}

bool contains(const core::Box& box, const glm::dvec3& p)
{
    return box.low.x <= p.x && p.x <= box.high.x && box.low.y <= p.y && p.y <= box.high.y &&
           box.low.z <= p.z && p.z <= box.high.z;
}

/// What is in the picture of a view.
struct ViewFrame {
    explicit ViewFrame(const hierarchy::View& view)
        : eye(view.eye), forward(glm::normalize(view.forward)),
          right(glm::normalize(glm::cross(forward, view.up))), up(glm::cross(right, forward)),
          tangent(std::tan(view.verticalFieldOfView / 2)),
          aspect(static_cast<double>(view.width) / view.height)
    {
    }
    [[nodiscard]] bool contains(const glm::dvec3& point) const
    {
        const glm::dvec3 offset = point - eye;
        const double depth = glm::dot(offset, forward);
        return depth > 0 && std::abs(glm::dot(offset, right)) <= depth * tangent * aspect &&
               std::abs(glm::dot(offset, up)) <= depth * tangent;
    }

    glm::dvec3 eye, forward, right, up;
    double tangent, aspect;
};

/// What a viewer sees past a mesh.
class Sight {
public:
    Sight(const hierarchy::View& view, const TriangleTree& tree)
        : _frame(view), _pixelsPerUnit(view.pixelsPerUnit()), _tree(tree)
    {
    }

    /// Pixels a unit of length at that point; 0 if it is not seen.
    /// @param margin  how far behind the mesh a point may lie, as a share of its distance
    [[nodiscard]] double pixelsAt(const glm::dvec3& point, double margin) const
    {
        if (!_frame.contains(point) || _tree.isBlocked(point, _frame.eye, std::min(0.5, margin)))
            return 0;
        return _pixelsPerUnit / glm::distance(point, _frame.eye);
    }

private:
    ViewFrame _frame;
    double _pixelsPerUnit;
    const TriangleTree& _tree;
};

} // namespace

Density pixelDensity(const hierarchy::View& view)
{
    const ViewFrame frame(view);
    return [frame](const glm::dvec3& middle, const glm::dvec3& area) {
        if (!frame.contains(middle))
            return 0.0;
        const glm::dvec3 offset = middle - frame.eye;
        const double squared = glm::dot(offset, offset);
        return std::abs(glm::dot(area, offset)) / (squared * std::sqrt(squared));
    };
}

MeshSamples samplesOf(const surface::TriangleMesh& mesh, std::size_t count, const Density& density)
{
    MeshSamples samples;
    const std::size_t triangles = mesh.indices.size() / 3;
    std::vector<double> areaUpTo(triangles);
    double total = 0;
    for (std::size_t t = 0; t < triangles; ++t) {
        const glm::dvec3& a = mesh.positions[mesh.indices[3 * t]];
        const glm::dvec3& b = mesh.positions[mesh.indices[3 * t + 1]];
        const glm::dvec3& c = mesh.positions[mesh.indices[3 * t + 2]];
        const glm::dvec3 area = 0.5 * glm::cross(b - a, c - a);
        total += density ? density((a + b + c) / 3.0, area) : glm::length(area);
        areaUpTo[t] = total;
    }
    if (!(total > 0))
        return samples;
    const bool hasNormals = mesh.normals.size() == mesh.positions.size();
    std::size_t t = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const double target = (static_cast<double>(i) + 0.5) / static_cast<double>(count) * total;
        while (t + 1 < triangles && areaUpTo[t] < target)
            ++t;
        // the R2 sequence of M. Roberts: points of the unit square that keep their distance
        double u = std::fmod(0.5 + 0.7548776662466927 * static_cast<double>(i + 1), 1.0);
        double v = std::fmod(0.5 + 0.5698402909980532 * static_cast<double>(i + 1), 1.0);
        if (u + v > 1) {
            u = 1 - u;
            v = 1 - v;
        }
        glm::dvec3 point(0.0);
        glm::dvec3 normal(0.0);
        for (std::size_t k = 0; k < 3; ++k) {
            const std::uint32_t corner = mesh.indices[3 * t + k];
            const double weight = k == 0 ? 1 - u - v : k == 1 ? u : v;
            point += weight * mesh.positions[corner];
            if (hasNormals)
                normal += weight * glm::dvec3(mesh.normals[corner]);
        }
        samples.points.push_back(point);
        const double length = glm::length(normal);
        samples.normals.push_back(length > 0 ? normal / length : glm::dvec3(0.0));
        samples.triangles.push_back(static_cast<std::uint32_t>(t));
    }
    return samples;
}

ErrorSpread spreadOf(std::vector<double> errors)
{
    ErrorSpread spread;
    spread.samples = errors.size();
    if (errors.empty())
        return spread;
    double squares = 0;
    for (const double error : errors) {
        squares += error * error;
        spread.max = std::max(spread.max, error);
    }
    spread.rms = std::sqrt(squares / static_cast<double>(errors.size()));
    const auto rank =
        static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(errors.size())) - 1);
    std::nth_element(
        errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(rank), errors.end());
    spread.p99 = errors[rank];
    return spread;
}

Reference referenceOf(
    const TrueSurface& surface,
    const surface::TriangleMesh& fineMesh,
    double reach,
    const core::Box& interior,
    std::size_t count,
    core::Jobs& jobs,
    const Density& density)
{
    const Topology topology = topologyOf(fineMesh);
    MeshSamples samples = samplesOf(fineMesh, count, density);
    std::vector<std::uint32_t> components;
    std::vector<std::size_t> seen(topology.components, 0);
    for (const std::uint32_t triangle : samples.triangles)
        ++seen[components.emplace_back(topology.componentOf[triangle])];
    constexpr std::size_t kLeast = 8; // points of a part that is small
    for (std::size_t t = 0; t < topology.componentOf.size(); ++t)
        if (const std::uint32_t component = topology.componentOf[t]; seen[component] < kLeast) {
            ++seen[component];
            components.push_back(component);
            samples.points.push_back(
                (fineMesh.positions[fineMesh.indices[3 * t]] +
                 fineMesh.positions[fineMesh.indices[3 * t + 1]] +
                 fineMesh.positions[fineMesh.indices[3 * t + 2]]) /
                3.0);
        }
    const auto landings = surface.project(samples.points, reach, jobs);
    Reference reference;
    std::vector<bool> counts(topology.components, false);
    for (std::size_t i = 0; i < landings.size(); ++i) {
        if (!landings[i].found || !contains(interior, landings[i].point))
            continue;
        reference.points.push_back(landings[i].point);
        reference.components.push_back(components[i]);
        counts[components[i]] = true;
    }
    reference.componentCount = static_cast<std::size_t>(std::ranges::count(counts, true));
    return reference;
}

Reference seenOf(
    const Reference& reference,
    const surface::TriangleMesh& fineMesh,
    const hierarchy::View& view,
    double stepPixels,
    core::Jobs& jobs)
{
    const TriangleTree tree(fineMesh);
    const Sight sight(view, tree);
    std::vector<char> isSeen(reference.points.size(), 0);
    forEach(jobs, isSeen.size(), [&](std::size_t i) {
        const double margin = 2 * stepPixels / view.pixelsPerUnit();
        isSeen[i] = sight.pixelsAt(reference.points[i], margin) > 0 ? 1 : 0;
    });
    Reference seen;
    std::vector<std::uint32_t> parts;
    for (std::size_t i = 0; i < isSeen.size(); ++i)
        if (isSeen[i] != 0) {
            seen.points.push_back(reference.points[i]);
            seen.components.push_back(reference.components[i]);
        }
    parts = seen.components;
    std::ranges::sort(parts);
    seen.componentCount =
        static_cast<std::size_t>(std::ranges::unique(parts).begin() - parts.begin());
    return seen;
}

DistanceMeasure::DistanceMeasure(
    TrueSurface surface,
    Reference reference,
    core::Box interior,
    double reach,
    std::size_t samples,
    std::shared_ptr<core::Jobs> jobs)
    : _surface(std::move(surface)), _reference(std::move(reference)), _interior(interior),
      _reach(reach), _samples(samples), _jobs(std::move(jobs))
{
}

SurfaceError DistanceMeasure::of(const surface::TriangleMesh& mesh, double step) const
{
    return weighted(
        samplesOf(mesh, _samples),
        TriangleTree(mesh),
        [step](const glm::dvec3&) { return step; },
        [](const glm::dvec3&) { return 1.0; },
        [](const glm::dvec3&) { return 1.0; });
}

SurfaceError DistanceMeasure::of(
    const surface::TriangleMesh& mesh, const hierarchy::View& view, double stepPixels) const
{
    const TriangleTree tree(mesh);
    const Sight sight(view, tree);
    constexpr double kOnMesh = 1e-6; // a point doesn't hide itself
    return weighted(
        samplesOf(mesh, _samples, pixelDensity(view)),
        tree,
        [&](const glm::dvec3& point) {
            return stepPixels / view.pixelsPerUnit() * glm::distance(point, view.eye);
        },
        [&](const glm::dvec3& point) { return sight.pixelsAt(point, kOnMesh); },
        [&](const glm::dvec3& point) {
            return view.pixelsPerUnit() / glm::distance(point, view.eye);
        });
}

SurfaceError DistanceMeasure::weighted(
    const MeshSamples& samples,
    const TriangleTree& tree,
    const Step& step,
    const Weight& meshWeight,
    const Weight& surfaceWeight) const
{
    SurfaceError error;
    constexpr double kLeftOut = -1;

    const auto landings = _surface.project(samples.points, _reach, *_jobs);
    std::vector<double> forward(samples.points.size(), kLeftOut);
    std::vector<double> angle(samples.points.size(), kLeftOut);
    std::vector<char> isLost(samples.points.size(), 0);
    forEach(*_jobs, samples.points.size(), [&](std::size_t i) {
        if (!contains(_interior, samples.points[i]))
            return;
        const double worth = meshWeight(samples.points[i]);
        if (worth <= 0)
            return;
        isLost[i] = landings[i].found ? 0 : 1;
        forward[i] =
            worth *
            (landings[i].found ? glm::distance(samples.points[i], landings[i].point) : _reach);
        if (landings[i].found && samples.normals[i] != glm::dvec3(0.0))
            angle[i] =
                kDegrees *
                std::acos(std::clamp(glm::dot(samples.normals[i], landings[i].normal), -1.0, 1.0));
    });

    std::vector<double> backward(_reference.points.size(), kLeftOut);
    std::vector<char> isNear(_reference.points.size(), 0);
    forEach(*_jobs, _reference.points.size(), [&](std::size_t i) {
        const double worth = surfaceWeight(_reference.points[i]);
        const double distance = tree.nearest(_reference.points[i]).distance;
        isNear[i] = distance <= step(_reference.points[i]) ? 1 : 0;
        if (worth > 0)
            backward[i] = worth * (std::isfinite(distance) ? distance : _reach);
    });
    if (!_reference.components.empty()) {
        std::vector<char> state(*std::ranges::max_element(_reference.components) + 1U, 0);
        for (std::size_t i = 0; i < isNear.size(); ++i) // 1: it has points; 2: one of them is met
            state[_reference.components[i]] =
                std::max<char>(state[_reference.components[i]], isNear[i] != 0 ? char{2} : char{1});
        error.missedComponents = static_cast<std::size_t>(std::ranges::count(state, char{1}));
    }

    const auto isLeftOut = [](double value) { return value < 0; };
    const auto measured = static_cast<double>(
        forward.size() - static_cast<std::size_t>(std::ranges::count_if(forward, isLeftOut)));
    if (measured > 0)
        error.lostShare = static_cast<double>(std::ranges::count(isLost, char{1})) / measured;
    std::erase_if(forward, isLeftOut);
    std::erase_if(angle, isLeftOut);
    std::erase_if(backward, isLeftOut);
    error.toSurface = spreadOf(std::move(forward));
    error.toMesh = spreadOf(std::move(backward));
    error.normal = spreadOf(std::move(angle));
    return error;
}

ErrorSpread distanceBetween(
    const surface::TriangleMesh& first,
    const surface::TriangleMesh& second,
    const core::Box& interior,
    std::size_t samples,
    core::Jobs& jobs)
{
    std::vector<double> errors;
    for (const auto& [from, to] : {std::pair{&first, &second}, std::pair{&second, &first}}) {
        const TriangleTree tree(*to);
        const MeshSamples points = samplesOf(*from, samples);
        std::vector<double> distances(points.points.size(), -1);
        forEach(jobs, distances.size(), [&](std::size_t i) {
            if (contains(interior, points.points[i]))
                distances[i] = tree.nearest(points.points[i]).distance;
        });
        for (const double distance : distances)
            if (distance >= 0 && std::isfinite(distance))
                errors.push_back(distance);
    }
    return spreadOf(std::move(errors));
}

} // namespace isofront::bench
