#include "MeshOptions.h"

#include "Arguments.h"

namespace isofront::cli {

namespace {

/// `--NAME` and `--no-NAME`.
void addSwitch(
    CLI::App& command, const std::string& name, std::optional<bool>& value, std::string what)
{
    command.add_flag_function(
        "--" + name + ",!--no-" + name,
        [&value](std::int64_t count) { value = count > 0; },
        std::move(what));
}

} // namespace

void MeshOptions::addTo(CLI::App& command)
{
    command
        .add_option(
            "--quality",
            quality,
            "of triangles: 'plain': as they are contoured; 'good': with --smooth 1 --reproject "
            "--align; 'best': with --simplify 0.02 --vertices balanced, too. Where such an option "
            "is given, it wins over the word")
        ->check(CLI::IsMember({"plain", "good", "best"}));
    command
        .add_option(
            "--smooth", smooth, "passes that even out triangles inside cells, 0 to 100; 1 or 2 do")
        ->check(CLI::Range(0, 100));
    addSwitch(
        command, "reproject", reproject, "then bring the vertices back to the surface, or don't");
    command
        .add_option(
            "--simplify",
            simplify,
            "remove vertices inside cells up to this error, in lattice steps; 0 removes none")
        ->check(within(0.0, 100.0));
    addSwitch(
        command,
        "align",
        align,
        "let edges follow the directions in which the surface bends least, or don't");
    command
        .add_option(
            "--vertices",
            vertices,
            "'surface': vertices lie on it; 'balanced': a little above, for the least error")
        ->check(CLI::IsMember({"surface", "balanced"}));
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
    const std::string word = quality.value_or("plain");
    const bool plain = word == "plain";
    const bool best = word == "best";
    settings.smoothIterations = smooth.value_or(plain ? 0 : 1);
    settings.reproject = reproject.value_or(!plain);
    settings.simplifyError = simplify.value_or(best ? 0.02 : 0.0);
    settings.alignEdges = align.value_or(!plain);
    settings.vertices = vertices.value_or(best ? "balanced" : "surface") == "balanced"
                            ? VertexPlacement::balanced
                            : VertexPlacement::onSurface;
    settings.normals = normals == "six"    ? NormalSource::sixSamples
                       : normals == "four" ? NormalSource::fourSamples
                                           : NormalSource::analytic;
}

void MeshOptions::describe(nlohmann::ordered_json& json) const
{
    extractor::ExtractionSettings settings;
    applyTo(settings);
    json["quality"] = quality.value_or("plain");
    json["smooth"] = settings.smoothIterations;
    json["reproject"] = settings.reproject;
    json["simplify"] = settings.simplifyError;
    json["align"] = settings.alignEdges;
    json["vertices"] =
        settings.vertices == extractor::VertexPlacement::balanced ? "balanced" : "surface";
    json["normals"] = normals;
}

} // namespace isofront::cli
