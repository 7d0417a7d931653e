#include "MeshOptions.h"

#include "Arguments.h"

namespace isofront::cli {

void MeshOptions::addTo(CLI::App& command)
{
    command
        .add_option(
            "--smooth", smooth, "passes that even out triangles inside cells, 0 to 100; 1 or 2 do")
        ->check(CLI::Range(0, 100))
        ->capture_default_str();
    command.add_flag(
        "--reproject", reproject, "then bring the vertices back to the surface by a Newton step");
    command
        .add_option(
            "--simplify",
            simplify,
            "remove vertices inside cells up to this error, in lattice steps; 0 removes none")
        ->check(within(0.0, 100.0))
        ->capture_default_str();
    command.add_flag(
        "--align", align, "let edges follow the directions in which the surface bends least");
    command
        .add_option(
            "--vertices",
            vertices,
            "'surface': vertices lie on it; 'balanced': a little above, for the least error")
        ->check(CLI::IsMember({"surface", "balanced"}))
        ->capture_default_str();
    command
        .add_option(
            "--normals",
            normals,
            "'analytic': the field's own gradient; 'six' or 'four': from so many samples")
        ->check(CLI::IsMember({"analytic", "six", "four"}))
        ->capture_default_str();
}

void MeshOptions::applyTo(extractor::ExtractionSettings& settings) const
{
    using extractor::NormalSource;
    using extractor::VertexPlacement;
    settings.smoothIterations = smooth;
    settings.reproject = reproject;
    settings.simplifyError = simplify;
    settings.alignEdges = align;
    settings.vertices =
        vertices == "balanced" ? VertexPlacement::balanced : VertexPlacement::onSurface;
    settings.normals = normals == "six"    ? NormalSource::sixSamples
                       : normals == "four" ? NormalSource::fourSamples
                                           : NormalSource::analytic;
}

void MeshOptions::describe(nlohmann::ordered_json& json) const
{
    json["smooth"] = smooth;
    json["reproject"] = reproject;
    json["simplify"] = simplify;
    json["align"] = align;
    json["vertices"] = vertices;
    json["normals"] = normals;
}

} // namespace isofront::cli
