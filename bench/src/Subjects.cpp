#include "Subjects.h"

#include <isofront/core/Assert.h>
#include <isofront/fields/Shapes.h>
#include <isofront/fields/Terrain.h>
#include <isofront/hierarchy/Criterion.h>

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <utility>

namespace isofront::bench {

namespace {

const glm::dvec3 kCentre(0.503, 0.491, 0.507);

/// 1 - (r / R)^8 about a centre.
class SteepBall final : public fields::Field {
public:
    SteepBall(const glm::dvec3& centre, double radius) : _centre(centre), _radius(radius) {}

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i)
            values[i] = static_cast<float>(
                valueAt(glm::distance({batch.x[i], batch.y[i], batch.z[i]}, _centre)));
    }
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override
    {
        for (std::size_t i = 0; i < batch.size(); ++i) {
            const glm::dvec3 offset = glm::dvec3(batch.x[i], batch.y[i], batch.z[i]) - _centre;
            const double share = glm::dot(offset, offset) / (_radius * _radius);
            const glm::dvec3 slope = -8 * share * share * share / (_radius * _radius) * offset;
            gradients.x[i] = slope.x;
            gradients.y[i] = slope.y;
            gradients.z[i] = slope.z;
        }
    }
    [[nodiscard]] core::Interval
    bounds(const core::Box& box, core::Interval /*radius*/) const override
    {
        const glm::dvec3 near = glm::clamp(_centre, box.low, box.high);
        const glm::dvec3 far = glm::max(glm::abs(box.low - _centre), glm::abs(box.high - _centre));
        const double slack = 1e-6;
        const double low = valueAt(glm::length(far));
        return {low - slack * (1 + std::abs(low)), valueAt(glm::distance(near, _centre)) + slack};
    }
    [[nodiscard]] double differenceStep(double /*radius*/) const override { return 1e-4; }

private:
    [[nodiscard]] double valueAt(double distance) const
    {
        const double share = distance * distance / (_radius * _radius);
        return 1 - share * share * share * share;
    }

    glm::dvec3 _centre;
    double _radius;
};

/// How far a mesh may lie from its surface and still be told how far, as a share of the edge.
constexpr double kReach = 0.05;

} // namespace

core::Box Subject::interior() const
{
    const core::Box box = domain.fieldBox();
    const glm::dvec3 margin = 0.05 * box.size();
    return {box.low + margin, box.high - margin};
}

TrueSurface Subject::surface(double filterRadius) const
{
    return {field, isovalue, domain.worldFromField, filterRadius};
}

Subject sphereSubject()
{
    return {"sphere", fields::sphere(kCentre, 0.37), {}, 0, true};
}

Subject steepSubject()
{
    return {"steep-ball", std::make_shared<SteepBall>(kCentre, 0.37), {}, 0, true};
}

Subject planeSubject()
{
    return {"plane", fields::plane(kCentre, {0.31, 0.17, 1}), {}, 0, true};
}

Subject torusSubject()
{
    return {"torus", fields::torus(kCentre, 0.3, 0.1), {}, 0, true};
}

Subject gyroidSubject()
{
    return {"gyroid", fields::gyroid(0.25), {glm::dvec3(0.0131, 0.0277, 0.0419), 1.0}, 0, true};
}

Subject canyonSubject(double filterStrength)
{
    constexpr double kEdge = 2048;
    const auto preset = fields::terrainPreset("canyon");
    ISOFRONT_ASSERT(preset.has_value(), "the canyon is one of the presets");
    auto field = fields::terrain(*preset, 7, filterStrength);
    const glm::dvec2 at = preset->start;
    const double height = fields::surfaceHeight(*field, preset->box, at.x, at.y);
    return {
        "canyon",
        std::move(field),
        {glm::dvec3(at.x, at.y, height) - glm::dvec3(kEdge / 2), kEdge},
        0,
        false};
}

extractor::ExtractionSettings settingsFor(const Subject& subject, int latticeSize, int level)
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = latticeSize;
    settings.isovalue = subject.isovalue;
    settings.filterStrength = 0;
    settings.cornerRadius = 2 * hierarchy::axisStep(level, latticeSize) * subject.domain.edge;
    return settings;
}

Polish goodTriangles()
{
    return [](extractor::ExtractionSettings& settings) {
        settings.smoothIterations = 1;
        settings.reproject = true;
        settings.alignEdges = true;
    };
}

Polish bestTriangles(double simplifyError)
{
    return [simplifyError](extractor::ExtractionSettings& settings) {
        goodTriangles()(settings);
        settings.simplifyError = simplifyError;
        settings.vertices = extractor::VertexPlacement::balanced;
    };
}

int levelForShare(double share, int latticeSize)
{
    int level = 0;
    while (hierarchy::axisStep(level, latticeSize) > share * (1 + 1e-9))
        level += 3;
    return level;
}

CellsMesh cellsMesh(
    const Subject& subject,
    const extractor::ExtractionSettings& settings,
    int level,
    std::size_t runs)
{
    const auto extractor =
        std::make_shared<const extractor::CellExtractor>(subject.field, subject.domain, settings);
    const auto jobs = core::makeJobs(core::JobsBackend::inlined);
    surface::MeshExtractionOptions options;
    options.detail.kind = surface::Detail::Kind::level;
    options.detail.level = level;
    CellsMesh cells;
    cells.step = hierarchy::axisStep(level, settings.latticeSize) * subject.domain.edge *
                 subject.domain.worldFromField.stretch();
    cells.timing = timed(
        [&] {
            if (auto mesh = surface::extractMesh(extractor, *jobs, options))
                cells.extracted = std::move(*mesh);
        },
        runs);
    return cells;
}

DistanceMeasure
measureFor(const Context& context, const Subject& subject, double share, std::size_t samples)
{
    constexpr int kLattice = 8;
    const int level = levelForShare(share, kLattice);
    const CellsMesh fine = cellsMesh(subject, settingsFor(subject, kLattice, level), level);
    const double reach = kReach * subject.domain.edge * subject.domain.worldFromField.stretch();
    const TrueSurface surface = subject.surface();
    return {
        surface,
        referenceOf(
            surface, fine.extracted.mesh, reach, subject.interior(), samples, *context.jobs),
        subject.interior(),
        reach,
        samples,
        context.jobs};
}

} // namespace isofront::bench
