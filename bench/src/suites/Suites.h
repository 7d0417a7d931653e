#pragma once

#include "isofront/bench/Suite.h"

namespace isofront::bench {

// One function a suite; what each answers stands in the list of Suite.cpp.

SuiteResult runAccuracy(const Context& context);
SuiteResult runBounds(const Context& context);
SuiteResult runClients(const Context& context);
SuiteResult runExtract(const Context& context);
SuiteResult runFrames(const Context& context);
SuiteResult runGrowth(const Context& context);
SuiteResult runHandOver(const Context& context);
SuiteResult runHilbert(const Context& context);
SuiteResult runIsovalue(const Context& context);
SuiteResult runKappa(const Context& context);
SuiteResult runLattice(const Context& context);
SuiteResult runLevels(const Context& context);
SuiteResult runNoise(const Context& context);
SuiteResult runNormals(const Context& context);
SuiteResult runPicture(const Context& context);
SuiteResult runPixelError(const Context& context);
SuiteResult runSimplify(const Context& context);
SuiteResult runSmooth(const Context& context);
SuiteResult runStages(const Context& context);
SuiteResult runStreaming(const Context& context);
SuiteResult runTransitions(const Context& context);
SuiteResult runView(const Context& context);
SuiteResult runVolumes(const Context& context);
SuiteResult runVertices(const Context& context);
SuiteResult runVoxelRays(const Context& context);
SuiteResult runVoxels(const Context& context);

/// What a suite of pictures says where one can't be drawn: a note if there is no device for it, a
/// check that fails otherwise, and nothing if the suite was stopped.
void noteUndrawn(SuiteResult& result, const Context& context, const core::Error& error);

} // namespace isofront::bench
