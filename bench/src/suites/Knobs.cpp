// One setting at a time: what it costs and what it does to the mesh.

#include "Figures.h"
#include "Subjects.h"
#include "Suites.h"

#include <algorithm>
#include <functional>
#include <string>

namespace isofront::bench {

namespace {

struct KnobValue {
    std::string name;
    double value = 0;
    std::function<void(extractor::ExtractionSettings&)> set;
};

struct Knob {
    std::string name;
    std::string unit;
    std::string meaning;
    std::vector<KnobValue> values;
    int latticeSize = 8;
};

/// A table with a row for each subject and value, all at one step.
Table swept(const Context& context, const Knob& knob, const std::vector<Subject>& subjects)
{
    Table table{
        knob.name,
        "Each value of this setting, at one step",
        {{"field", "", "what is meshed"},
         {knob.name, "", "setting"},
         {"value", knob.unit, knob.meaning}},
        {},
        {{"error", knob.name + ": error", "value", "rms", "field", "", "", false, true, {}},
         {"cpu", knob.name + ": time", "value", "cpu", "field", "", "", false, true, {}}}};
    appendFigureColumns(table);
    const double share = context.pick(1.0 / 32, 1.0 / 64);
    for (const Subject& subject : subjects) {
        const DistanceMeasure measure = measureFor(
            context,
            subject,
            context.pick(1.0 / 64, 1.0 / 256),
            context.pick<std::size_t>(500, 20000));
        for (const KnobValue& value : knob.values) {
            if (context.isStopped())
                return table;
            context.say(subject.name + ", " + value.name);
            const int level = levelForShare(share, knob.latticeSize);
            extractor::ExtractionSettings settings = settingsFor(subject, knob.latticeSize, level);
            value.set(settings);
            const CellsMesh cells = cellsMesh(subject, settings, level, context.runs());
            std::vector<Cell> row{subject.name, value.name, value.value};
            appendFigures(
                row, cells.extracted.mesh, cells.step, subject.domain.edge, cells.timing, measure);
            table.add(std::move(row));
        }
    }
    return table;
}

/// What is done inside cells leaves parts and handles as they were.
void checkTopologyOf(SuiteResult& result, const Table& table)
{
    for (std::size_t row = 0; row < table.rows.size(); ++row)
        if (table.word(row, "field") == "sphere")
            result.check(
                "the sphere is still a ball at " + table.name + " " + table.word(row, table.name),
                table.number(row, "euler") == 2,
                "Euler number " + textOf(table.number(row, "euler")));
}

} // namespace

SuiteResult runLattice(const Context& context)
{
    Table table{
        "lattice",
        "Lattice sizes at equal steps",
        {{"field", "", "what is meshed"},
         {"lattice", "", "n"},
         {"level", "", "of the cells"},
         {"cells", "", "of the front"},
         {"sampled", "", "cells that were not proved empty"},
         {"samples", "", "of the field"},
         {"samples_per_triangle", "", "samples for each triangle"},
         {"cpu_per_triangle", "us", "processor time for each triangle"}},
        {},
        {}};
    appendFigureColumns(table);
    SuiteResult result;
    const std::vector<int> resolutions = context.pick<std::vector<int>>({32}, {32, 64, 128});
    for (const Subject& subject : {sphereSubject(), gyroidSubject(), canyonSubject()}) {
        const DistanceMeasure measure = measureFor(
            context,
            subject,
            context.pick(1.0 / 64, 1.0 / 256),
            context.pick<std::size_t>(500, 20000));
        for (const int n : {4, 8, 16})
            for (const int resolution : resolutions) {
                if (context.isStopped())
                    return result;
                context.say(
                    subject.name + ", n = " + std::to_string(n) + ", 1/" +
                    std::to_string(resolution));
                const int level = levelForShare(1.0 / resolution, n);
                const CellsMesh cells =
                    cellsMesh(subject, settingsFor(subject, n, level), level, context.runs());
                const auto triangles = static_cast<double>(
                    std::max<std::size_t>(cells.extracted.mesh.indices.size() / 3, 1));
                std::vector<Cell> row{
                    subject.name,
                    std::to_string(n),
                    count(level),
                    count(cells.extracted.cells),
                    count(cells.extracted.cells - cells.extracted.cellsSkipped),
                    count(cells.extracted.samples),
                    static_cast<double>(cells.extracted.samples) / triangles,
                    1e6 * cells.timing.least / triangles};
                appendFigures(
                    row,
                    cells.extracted.mesh,
                    cells.step,
                    subject.domain.edge,
                    cells.timing,
                    measure);
                table.add(std::move(row));
            }
        table.plots.push_back(
            {subject.name + "-cpu",
             subject.name + ": error over time for each lattice size",
             "cpu",
             "error",
             "lattice",
             "field",
             subject.name,
             true,
             true,
             {}});
    }
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runVertices(const Context& context)
{
    using extractor::VertexPlacement;
    const auto by = [](VertexPlacement placement, bool aligned) {
        return [placement, aligned](extractor::ExtractionSettings& settings) {
            settings.vertices = placement;
            settings.alignEdges = aligned;
        };
    };
    const Knob knob{
        "vertices",
        "",
        "as listed in the table",
        {{"on the surface", 0, by(VertexPlacement::onSurface, false)},
         {"on the surface, edges aligned", 1, by(VertexPlacement::onSurface, true)},
         {"balanced", 2, by(VertexPlacement::balanced, false)},
         {"balanced, edges aligned", 3, by(VertexPlacement::balanced, true)},
         {"good", 4, goodTriangles()},
         {"best, nothing removed", 5, bestTriangles(0)},
         {"best", 6, bestTriangles()}},
        8};
    SuiteResult result;
    Table table = swept(context, knob, {sphereSubject(), gyroidSubject(), canyonSubject()});
    checkTopologyOf(result, table);
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runNormals(const Context& context)
{
    using extractor::NormalSource;
    const auto by = [](NormalSource source) {
        return [source](extractor::ExtractionSettings& settings) { settings.normals = source; };
    };
    const Knob knob{
        "normals",
        "",
        "samples a vertex",
        {{"analytic", 0, by(NormalSource::analytic)},
         {"four samples", 4, by(NormalSource::fourSamples)},
         {"six samples", 6, by(NormalSource::sixSamples)}},
        8};
    SuiteResult result;
    Table table = swept(context, knob, {sphereSubject(), gyroidSubject(), canyonSubject()});
    table.plots = {
        {"angle", "Angle of normals", "value", "normal", "field", "", "", false, true, {}}};
    for (std::size_t row = 0; row < table.rows.size(); ++row)
        if (table.word(row, "normals") != "analytic")
            result.check(
                "normals by " + table.word(row, "normals") + " leave the positions of the " +
                    table.word(row, "field") + " alone",
                table.word(row, "checksum") == table.word(row - (row % 3), "checksum"),
                table.word(row, "checksum"));
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runSmooth(const Context& context)
{
    const auto passes = [](int count, bool reproject) {
        return [count, reproject](extractor::ExtractionSettings& settings) {
            settings.smoothIterations = count;
            settings.reproject = reproject;
        };
    };
    Knob knob{"smooth", "", "passes of smoothing", {{"none", 0, passes(0, false)}}, 8};
    for (const bool reproject : {false, true})
        for (const int count : {1, 2, 3, 5})
            knob.values.push_back(
                {std::to_string(count) + (reproject ? ", brought back" : ""),
                 static_cast<double>(count),
                 passes(count, reproject)});
    SuiteResult result;
    Table table = swept(context, knob, {sphereSubject(), gyroidSubject(), canyonSubject()});
    table.plots = {
        {"slivers", "Slivers over error", "rms", "slivers", "field", "", "", false, false, {}}};
    checkTopologyOf(result, table);
    result.tables = {std::move(table)};
    return result;
}

SuiteResult runSimplify(const Context& context)
{
    Knob knob{"simplify", "steps", "error that removals may make", {}, 8};
    for (const double error : {0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.3})
        knob.values.push_back(
            {textOf(error), error, [error](extractor::ExtractionSettings& settings) {
                 settings.simplifyError = error;
             }});
    SuiteResult result;
    Table table = swept(context, knob, {sphereSubject(), gyroidSubject(), canyonSubject()});
    table.plots = {
        {"triangles",
         "Error over triangles that are left",
         "triangles",
         "rms",
         "field",
         "",
         "",
         true,
         true,
         {}},
        {"cpu", "Simplification: time", "value", "cpu", "field", "", "", false, true, {}}};
    checkTopologyOf(result, table);
    for (std::size_t row = 0; row + 1 < table.rows.size(); ++row)
        if (table.word(row, "field") == table.word(row + 1, "field"))
            result.check(
                "more error allowed leaves no more triangles, " + table.word(row, "field") + " " +
                    table.word(row + 1, "simplify"),
                table.number(row + 1, "triangles") <= table.number(row, "triangles"),
                textOf(table.number(row, "triangles")) + " to " +
                    textOf(table.number(row + 1, "triangles")));
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench
