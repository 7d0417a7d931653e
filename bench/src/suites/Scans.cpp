#include "Scans.h"

#include <isofront/hierarchy/Criterion.h>

#include <glm/geometric.hpp>

#include <filesystem>
#include <system_error>
#include <utility>

namespace isofront::bench {

namespace {

constexpr int kLatticeSize = 4;

} // namespace

hierarchy::View OpenScan::view() const
{
    core::Box box;
    for (unsigned corner = 0; corner < 8; ++corner)
        box.include(domain.worldFromField.point(
            {(corner & 1U) != 0 ? volume.dataBox.high.x : volume.dataBox.low.x,
             (corner & 2U) != 0 ? volume.dataBox.high.y : volume.dataBox.low.y,
             (corner & 4U) != 0 ? volume.dataBox.high.z : volume.dataBox.low.z}));
    const glm::dvec3 from = 1.6 * glm::length(box.size()) * glm::dvec3(-0.36, -0.80, 0.48);
    hierarchy::View view;
    view.eye = box.centre() + from;
    return view;
}

extractor::ExtractionSettings OpenScan::settings(double atIsovalue, double filterStrength) const
{
    extractor::ExtractionSettings settings;
    settings.latticeSize = kLatticeSize;
    settings.isovalue = volume::fieldIsovalue(volume, atIsovalue);
    settings.filterStrength = filterStrength;
    settings.cornerRadius = 2; // voxels: that of the native level, as the command has it
    return settings;
}

std::vector<OpenScan> opened(const Context& context, const std::vector<Scan>& scans)
{
    std::vector<OpenScan> found;
    for (const Scan& scan : scans)
        for (const std::filesystem::path& folder : context.dataFolders) {
            std::error_code error;
            if (!std::filesystem::exists(folder / scan.file, error))
                continue;
            auto volume = volume::loadVolume(folder / scan.file);
            if (!volume)
                continue;
            OpenScan open;
            open.name = scan.name;
            open.isovalue = scan.isovalue;
            open.volume = std::move(*volume);
            open.domain = {
                open.volume.domainOrigin, open.volume.domainEdge, open.volume.worldFromIndex};
            while (hierarchy::axisStep(open.nativeLevel, kLatticeSize) * open.domain.edge > 1)
                open.nativeLevel += 3;
            found.push_back(std::move(open));
            break;
        }
    return found;
}

std::shared_ptr<const extractor::CellExtractor>
extractorFor(const OpenScan& scan, const extractor::ExtractionSettings& settings)
{
    return std::make_shared<const extractor::CellExtractor>(
        scan.volume.field, scan.domain, settings);
}

} // namespace isofront::bench
