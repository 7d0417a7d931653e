// After Scholz, Bender, Dachsbacher, "Real-Time Isosurface Extraction with View-Dependent Level of
// Detail and Applications", section 3.3: what the low-pass filter trades.

#include "Subjects.h"
#include "Suites.h"

#include <isofront/fields/Noise.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

namespace isofront::bench {

namespace {

/// A field at one filter radius, whatever radius is asked for.
class AtRadius final : public fields::Field {
public:
    AtRadius(std::shared_ptr<const fields::Field> field, double radius)
        : _field(std::move(field)), _radius(radius)
    {
    }
    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        const std::vector<double> radius(batch.size(), _radius);
        _field->sample({batch.x, batch.y, batch.z, radius}, values);
    }
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override
    {
        const std::vector<double> radius(batch.size(), _radius);
        _field->gradient({batch.x, batch.y, batch.z, radius}, gradients);
    }
    [[nodiscard]] core::Interval
    bounds(const core::Box& box, core::Interval /*radius*/) const override
    {
        return _field->bounds(box, {_radius, _radius});
    }
    [[nodiscard]] double differenceStep(double /*radius*/) const override
    {
        return _field->differenceStep(_radius);
    }

private:
    std::shared_ptr<const fields::Field> _field;
    double _radius;
};

Subject noiseSubject()
{
    fields::NoiseSettings settings;
    settings.seed = 5;
    settings.wavelength = 0.5;
    settings.octaves = 7;
    return {"noise", fields::fractalNoise(settings), {}, 0, false};
}

} // namespace

SuiteResult runKappa(const Context& context)
{
    Table table{
        "kappa",
        "What the filter's strength does at one step",
        {{"field", "", "what is meshed"},
         {"kappa", "", "strength of the filter"},
         {"triangles", "", "triangles"},
         {"cpu", "ms", "processor time, one thread"},
         {"error", "steps", "mesh to the unfiltered surface, root mean square"},
         {"loss", "steps", "unfiltered surface to mesh, root mean square: lost parts weigh most"},
         {"p99", "steps", "mesh to the unfiltered surface, 99 % below"},
         {"alias", "steps", "mesh to the surface of the field filtered as much: what is no detail"},
         {"popping",
          "steps",
          "to the mesh of the next level (half the step): what is seen to move"},
         {"missed", "", "parts of the unfiltered surface without mesh"}},
        {},
        {}};
    constexpr int kLattice = 8;
    const std::size_t samples = context.pick<std::size_t>(500, 20000);
    SuiteResult result;
    for (const Subject& subject : {noiseSubject(), canyonSubject()}) {
        const int level = levelForShare(context.pick(1.0 / 32, 1.0 / 64), kLattice);
        const DistanceMeasure unfiltered =
            measureFor(context, subject, context.pick(1.0 / 64, 1.0 / 256), samples);
        double firstAlias = 0;
        for (const double kappa : {0.0, 0.5, 1.0, 1.5, 2.0, 3.0}) {
            if (context.isStopped())
                return result;
            context.say(subject.name + ", kappa " + textOf(kappa));
            const auto filtered = [&](int atLevel) {
                extractor::ExtractionSettings settings = settingsFor(subject, kLattice, atLevel);
                settings.filterStrength = kappa;
                // that of the finest cells: the finer of the two levels that are compared
                settings.cornerRadius = settingsFor(subject, kLattice, level + 3).cornerRadius;
                return cellsMesh(subject, settings, atLevel, atLevel == level ? 3 : 1);
            };
            const CellsMesh coarse = filtered(level);
            const CellsMesh fine = filtered(level + 3);
            const SurfaceError error = unfiltered.of(coarse.extracted.mesh, coarse.step);
            const ErrorSpread popping = distanceBetween(
                coarse.extracted.mesh,
                fine.extracted.mesh,
                subject.interior(),
                samples,
                *context.jobs);
            // A cell's radius is two axis steps times kappa; held constant, so that the same field
            // can be meshed coarsely and known exactly.
            const double radius = kappa * 2 * coarse.step;
            Subject even = subject;
            even.field = std::make_shared<AtRadius>(subject.field, radius);
            const CellsMesh evenMesh =
                cellsMesh(even, settingsFor(even, kLattice, level), level, 1);
            const SurfaceError alias =
                measureFor(context, even, context.pick(1.0 / 64, 1.0 / 256), samples)
                    .of(evenMesh.extracted.mesh, evenMesh.step);
            // one way: parts that fall between samples are told by `missed`
            const double aliasRms = alias.toSurface.rms / coarse.step;
            if (kappa == 0)
                firstAlias = aliasRms;
            else if (kappa == 2)
                result.check(
                    "filtering lowers the aliasing of the " + subject.name,
                    aliasRms < firstAlias,
                    textOf(firstAlias) + " to " + textOf(aliasRms) + " steps");
            table.add(
                {subject.name,
                 kappa,
                 count(coarse.extracted.mesh.indices.size() / 3),
                 1e3 * coarse.timing.least,
                 error.toSurface.rms / coarse.step,
                 error.toMesh.rms / coarse.step,
                 error.toSurface.p99 / coarse.step,
                 aliasRms,
                 popping.rms / coarse.step,
                 count(error.missedComponents)});
        }
    }
    for (const auto& [column, title] :
         {std::pair{"error", "error against the unfiltered field"},
          std::pair{"alias", "aliasing"},
          std::pair{"popping", "popping"}})
        table.plots.push_back(
            {column,
             std::string("Strength of the filter: ") + title,
             "kappa",
             column,
             "field",
             "",
             "",
             false,
             false,
             {}});
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench
