#pragma once

#include "isofront/bench/Suite.h"

#include <isofront/extractor/CellExtractor.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/hierarchy/View.h>
#include <isofront/volume/LoadVolume.h>

#include <memory>
#include <string>
#include <vector>

namespace isofront::bench {

/// A file that figures are given for, if it is there.
struct Scan {
    const char* name;
    const char* file;
    double isovalue;
};

/// One that is.
struct OpenScan {
    std::string name;
    double isovalue = 0; ///< as the file has it
    volume::LoadedVolume volume;
    hierarchy::Domain domain;
    int nativeLevel = 0; ///< at which a step of a lattice of size 4 is one voxel

    /// From the front, to the left and above: 1.6 diagonals from the middle of the data.
    [[nodiscard]] hierarchy::View view() const;
    /// How it is extracted: with lattices of size 4, and normals as the command has them.
    [[nodiscard]] extractor::ExtractionSettings
    settings(double atIsovalue, double filterStrength) const;
};

/// Those that one of the context's folders has and that can be read.
std::vector<OpenScan> opened(const Context& context, const std::vector<Scan>& scans);

std::shared_ptr<const extractor::CellExtractor>
extractorFor(const OpenScan& scan, const extractor::ExtractionSettings& settings);

} // namespace isofront::bench
