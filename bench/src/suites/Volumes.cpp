#include "Figures.h"
#include "Subjects.h"
#include "Suites.h"
#include "isofront/bench/GridContour.h"

#include <isofront/volume/LoadVolume.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace isofront::bench {

namespace {

/// Files that loadVolume may read, by name.
std::vector<std::filesystem::path> volumesIn(const std::vector<std::filesystem::path>& folders)
{
    std::vector<std::filesystem::path> files;
    for (const auto& folder : folders) {
        std::error_code ignored;
        for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
            const std::string name = entry.path().filename().string();
            const auto endsWith = [&](const char* end) { return name.ends_with(end); };
            const bool isKnown = std::ranges::any_of(files, [&](const auto& file) {
                return file.filename() == entry.path().filename();
            });
            if (!isKnown && (endsWith(".nrrd") || endsWith(".nii") || endsWith(".nii.gz") ||
                             endsWith(".mha") || endsWith(".mhd") || endsWith(".vdb")))
                files.push_back(entry.path());
        }
    }
    std::ranges::sort(files, {}, [](const auto& file) { return file.filename().string(); });
    return files;
}

} // namespace

SuiteResult runVolumes(const Context& context)
{
    Table table{
        "volumes",
        "Volumes at one lattice step a voxel",
        {{"file", "", "volume"},
         {"voxels", "M", "of its data box"},
         {"isovalue", "", "that separates it best"},
         {"method", "", "cells, or marching cubes on the voxels"},
         {"voxel_rate", "Mvoxel/s", "voxels over processor time"}},
        {},
        {}};
    appendFigureColumns(table);
    SuiteResult result;
    constexpr int kLattice = 4;
    const double most = context.pick(0.4, 20.0); // million voxels
    for (const auto& file : volumesIn(context.dataFolders)) {
        if (context.isStopped())
            return result;
        const std::string name = file.filename().string();
        context.say(name);
        const auto loaded = volume::loadVolume(file);
        if (!loaded) {
            // a format whose reader is not built in is no failure of ours
            result.check(
                name + " is read or refused for its format",
                loaded.error().code == core::ErrorCode::usage,
                loaded.error().message);
            continue;
        }
        const glm::dvec3 size = loaded->dataBox.size();
        const double voxels = (size.x + 1) * (size.y + 1) * (size.z + 1) * 1e-6;
        if (voxels > most)
            continue;
        // in voxels, not in the world: so steps and errors are those of the data
        Subject subject;
        subject.name = name;
        subject.field = loaded->field;
        subject.domain = {loaded->domainOrigin, loaded->domainEdge, {}};
        subject.isovalue = volume::fieldIsovalue(*loaded, loaded->info.suggestedIsovalue);
        subject.isSmooth = false;
        const int level = levelForShare(1 / loaded->domainEdge, kLattice);
        const core::Box interior{
            loaded->dataBox.low + glm::dvec3(2), loaded->dataBox.high - glm::dvec3(2)};
        const TrueSurface surface = subject.surface();
        const CellsMesh fine =
            cellsMesh(subject, settingsFor(subject, 8, level), level); // half a voxel
        const std::size_t samples = context.pick<std::size_t>(2000, 20000);
        constexpr double kReach = 3; // [voxels]
        const DistanceMeasure measure(
            surface,
            referenceOf(surface, fine.extracted.mesh, kReach, interior, samples, *context.jobs),
            interior,
            kReach,
            samples,
            context.jobs);
        const auto add = [&](const std::string& method,
                             const surface::TriangleMesh& mesh,
                             const Timing& timing) {
            std::vector<Cell> row{
                name,
                voxels,
                loaded->info.suggestedIsovalue,
                method,
                voxels / std::max(timing.least, 1e-9)};
            appendFigures(row, mesh, 1, loaded->domainEdge, timing, measure);
            table.add(std::move(row));
        };
        const CellsMesh cells = cellsMesh(subject, settingsFor(subject, kLattice, level), level, 3);
        add("cells n=4", cells.extracted.mesh, cells.timing);
        // the voxels alone, so that neither method pays for the room around them
        GridSamples grid;
        grid.origin = loaded->dataBox.low;
        surface::TriangleMesh plain;
        const Timing plainTiming = timed(
            [&] {
                const glm::i64vec3 points = glm::i64vec3(size) + glm::i64vec3(1);
                const fields::SampleGrid wanted{grid.origin, 1, glm::i64vec3(0), points, 0};
                grid.count = {int(points.x), int(points.y), int(points.z)};
                grid.values.resize(wanted.size());
                subject.field->sampleGrid(wanted, grid.values);
                plain = marchingCubes(grid, subject.isovalue, subject.domain, subject.field.get());
            },
            3);
        add("marching cubes", plain, plainTiming);
    }
    result.tables = {std::move(table)};
    return result;
}

} // namespace isofront::bench
