#include "isofront/bench/Suite.h"

#include "suites/Suites.h"

#include <algorithm>

namespace isofront::bench {

const std::vector<Suite>& suites()
{
    static const std::vector<Suite> all = {
        {"accuracy",
         "How far is the mesh from the true surface, by triangles and time, against other methods?",
         runAccuracy},
        {"lattice",
         "Are many small cells with few samples better than few large ones with many?",
         runLattice},
        {"pixel-error", "How much error is seen when so much is asked for?", runPixelError},
        {"kappa", "What does the low-pass filter take away, and what does it spare?", runKappa},
        {"smooth", "What do passes of smoothing do to slivers, and to the error?", runSmooth},
        {"simplify", "How many triangles does an error that is allowed save?", runSimplify},
        {"vertices", "What do better places for vertices and edges save?", runVertices},
        {"normals", "How good are normals from fewer samples?", runNormals},
        {"stages", "Where does the time in a cell go?", runStages},
        {"growth", "How do time and memory grow with the domain?", runGrowth},
        {"hilbert", "What is the order of triangles worth to a vertex cache?", runHilbert},
        {"volumes", "How fast and how good are meshes of volume files?", runVolumes},
        {"bounds", "How many of the empty cells are never sampled?", runBounds},
        {"noise",
         "How fast is noise with each instruction set, against the machine's multiply-adds?",
         runNoise},
        {"extract", "How fast do volumes become triangles, against flying edges?", runExtract},
        {"view", "How fast is there what a view needs?", runView},
        {"streaming",
         "Which chunks of voxels does a flight bring and draw, frame by frame?",
         runStreaming},
        {"voxels", "How fast do meshes become surface voxels, and what do they take?", runVoxels},
        {"isovalue", "How soon is another isovalue there?", runIsovalue},
        {"voxel-rays", "How fast do rays find voxels, against triangles?", runVoxelRays},
        {"levels", "At which distance do levels of detail change?", runLevels},
#ifdef ISOFRONT_WITH_SERVER
        {"clients",
         "How many clients does a service keep up to date, and what does each take?",
         runClients},
#endif
#ifdef ISOFRONT_WITH_VULKAN
        {"frames", "What do frames of a flight past voxels cost, in time and memory?", runFrames},
        {"picture", "How long does a picture take, by voxels and by rays?", runPicture},
        {"transitions", "How smoothly does one level of detail become another?", runTransitions},
        {"hand-over", "What is seen when voxels take the place of meshes?", runHandOver},
#endif
    };
    return all;
}

core::Result<std::vector<Suite>> suitesNamed(const std::vector<std::string>& names)
{
    if (names.empty())
        return suites();
    std::string known;
    for (const Suite& suite : suites())
        known += (known.empty() ? "" : ", ") + suite.name;
    for (const std::string& name : names)
        if (std::ranges::find(suites(), name, &Suite::name) == suites().end())
            return core::failure(
                core::ErrorCode::usage, "unknown suite '" + name + "': there are " + known);
    std::vector<Suite> chosen;
    std::ranges::copy_if(suites(), std::back_inserter(chosen), [&](const Suite& suite) {
        return std::ranges::find(names, suite.name) != names.end();
    });
    return chosen;
}

void noteUndrawn(SuiteResult& result, const Context& context, const core::Error& error)
{
    if (error.code == core::ErrorCode::noDevice)
        result.notes = {"not measured: " + error.message};
    else if (!context.isStopped())
        result.check("pictures are drawn", false, error.message);
}

} // namespace isofront::bench
