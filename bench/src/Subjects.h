#pragma once

#include "isofront/bench/DistanceMeasure.h"
#include "isofront/bench/Suite.h"
#include "isofront/bench/Timing.h"

#include <isofront/core/Box.h>
#include <isofront/extractor/CellExtractor.h>
#include <isofront/fields/Field.h>
#include <isofront/hierarchy/Domain.h>
#include <isofront/surface/MeshExtraction.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace isofront::bench {

/// A field to measure with, in a domain of which the border is left out. Its lengths are those of
/// the domain, so tables give them as shares of its edge.
struct Subject {
    std::string name;
    std::shared_ptr<const fields::Field> field;
    hierarchy::Domain domain;
    double isovalue = 0;
    bool isSmooth = true; ///< its error falls with the square of the step

    /// The domain without a twentieth at each side [world].
    [[nodiscard]] core::Box interior() const;
    [[nodiscard]] TrueSurface surface(double filterRadius = 0) const;
};

/// A ball of radius 0.37 in a unit cube, about a place where no lattice point lies.
Subject sphereSubject();
/// The same ball by a value that is strongly bent across it, 1 - (r / 0.37)^8: what linear
/// interpolation does worst.
Subject steepSubject();
/// A plane that lies askew to every lattice.
Subject planeSubject();
/// A torus, tube over ring one third, about the same place.
Subject torusSubject();
/// A gyroid of four periods, shifted off the lattice.
Subject gyroidSubject();
/// Two kilometres of the canyon at its start.
Subject canyonSubject(double filterStrength = 1);

/// How an extraction is set up for lattices of one size at one level, unfiltered.
extractor::ExtractionSettings settingsFor(const Subject& subject, int latticeSize, int level);

/// Changes how triangles are made.
using Polish = std::function<void(extractor::ExtractionSettings&)>;
/// What `extract --quality good` does.
Polish goodTriangles();
/// What `extract --quality best` does, but with so much removed [axis steps].
Polish bestTriangles(double simplifyError = 0.02);

/// The coarsest level 3k whose axis step is at most this share of the domain's edge.
int levelForShare(double share, int latticeSize);

struct CellsMesh {
    surface::ExtractedMesh extracted;
    double step = 0; ///< axis step [world]
    Timing timing;   ///< of the whole extraction, on one thread
};

/// A mesh by the product's own cells, at one level everywhere. What fails (out of memory) gives an
/// empty mesh.
/// @param runs  how often to time it, within about a second
CellsMesh cellsMesh(
    const Subject& subject,
    const extractor::ExtractionSettings& settings,
    int level,
    std::size_t runs = 1);

/// The measure for a subject, with points of it from a lattice of `share` of the domain's edge.
DistanceMeasure
measureFor(const Context& context, const Subject& subject, double share, std::size_t samples);

} // namespace isofront::bench
