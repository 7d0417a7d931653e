#include "Arguments.h"
#include "Console.h"

#include <exception>
#include <map>
#include <new>

int main(int argc, char** argv)
{
    using namespace isofront;

    CLI::App app{
        "Isofront shows, streams and exports the isosurface of any scalar field at the detail\n"
        "a view needs.\n\n"
        "SOURCE is a volume (.nrrd .nhdr .nii .nii.gz .mha .mhd .vdb .raw, a folder of DICOM\n"
        "or TIFF slices), an elevation raster (.hgt .hgt.gz .tif .png) or a procedural field,\n"
        "proc:NAME[?key=value&...]; 'isofront info proc:' lists those. 'voxelize' takes meshes.\n"};
    app.name("isofront");
    app.require_subcommand(1);
    app.set_version_flag("--version", "isofront " ISOFRONT_VERSION);
    app.footer(
        "Examples:\n"
        "  isofront fly --preset canyon --out flight\n"
        "  isofront info head.nrrd\n"
        "  isofront extract head.nrrd --isovalue 300 --closed -o bone.glb\n"
        "  isofront render proc:julia -o julia.png\n"
        "  isofront tiles head.nrrd --isovalue 300 -o head-tiles\n"
        "  isofront voxelize dragon.ply.gz --resolution 2048 -o dragon.voxels\n"
        "  isofront serve --sources ~/scans\n\n"
        "Exit codes: 0 done, 2 bad usage, 3 bad input data, 4 input/output failure, 5 no usable\n"
        "device, 6 resource limit, 130 interrupted. 'isofront COMMAND --help' tells more.");

    std::map<std::string, cli::Action> actions;
#ifdef ISOFRONT_WITH_BENCH
    actions["bench"] = cli::addBench(app);
#endif
    actions["extract"] = cli::addExtract(app);
    actions["info"] = cli::addInfo(app);
    actions["tiles"] = cli::addTiles(app);
    actions["voxelize"] = cli::addVoxelize(app);
#ifdef ISOFRONT_WITH_SERVER
    actions["serve"] = cli::addServe(app);
#endif
#ifdef ISOFRONT_WITH_VULKAN
    actions["fly"] = cli::addFly(app);
    actions["render"] = cli::addRender(app);
#endif

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& success) {
        return app.exit(success); // --help and --version
    } catch (const CLI::ParseError& error) {
        if (app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-') {
            std::string names;
            for (const auto& [name, action] : actions)
                names += (names.empty() ? "" : ", ") + name;
            return cli::report(
                {core::ErrorCode::usage,
                 "unknown command '" + std::string(argv[1]) + "': there are " + names +
                     " (see 'isofront --help')"});
        }
        return cli::report(
            {core::ErrorCode::usage,
             std::string(error.what()) + " (see 'isofront " +
                 (app.get_subcommands().empty() ? ""
                                                : app.get_subcommands().front()->get_name() + " ") +
                 "--help')"});
    }
    try {
        return cli::finishOutput(actions.at(app.get_subcommands().front()->get_name())());
    } catch (const std::bad_alloc&) {
        return cli::report(
            {core::ErrorCode::resourceLimit,
             "out of memory: choose a coarser detail, or a lower --memory-limit to be told "
             "earlier"});
    } catch (const std::exception& error) {
        return cli::report(
            {core::ErrorCode::inputOutput, std::string("unexpected failure: ") + error.what()});
    }
}
