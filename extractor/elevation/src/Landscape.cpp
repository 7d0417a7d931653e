#include "isofront/elevation/Landscape.h"

#include <isofront/fields/Graph.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace isofront::elevation {

namespace {

/// A field that has data in a box only.
class Framed final : public fields::Field {
public:
    Framed(std::shared_ptr<const fields::Field> inner, core::Box box)
        : _inner(std::move(inner)), _box(box)
    {
    }

    void sample(const fields::SampleBatch& batch, std::span<float> values) const override
    {
        _inner->sample(batch, values);
    }
    void gradient(const fields::SampleBatch& batch, fields::GradientSpans gradients) const override
    {
        _inner->gradient(batch, gradients);
    }
    void sampleWithGradient(
        const fields::SampleBatch& batch,
        std::span<float> values,
        fields::GradientSpans gradients) const override
    {
        _inner->sampleWithGradient(batch, values, gradients);
    }
    [[nodiscard]] core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return _inner->bounds(box, radius);
    }
    [[nodiscard]] double differenceStep(double radius) const override
    {
        return _inner->differenceStep(radius);
    }
    [[nodiscard]] std::optional<core::Box> dataBox() const override { return _box; }

private:
    std::shared_ptr<const fields::Field> _inner;
    core::Box _box;
};

/// How many octaves there are from a wavelength down to a few centimetres, at most 14. Halves are
/// exact, so that all machines agree, as they might not on a logarithm.
int octavesFrom(double wavelength)
{
    constexpr double kShortest = 0.1; // [m]
    int octaves = 1;
    for (double half = 0.25 * wavelength; half >= kShortest && octaves < 14; half *= 0.5)
        ++octaves;
    return octaves;
}

fields::graph::Node nodeOf(const LoadedElevation& elevation, const LandscapePreset& preset)
{
    using namespace fields::graph;
    const glm::dvec2 spacing = elevation.info.spacing;
    const double post = std::sqrt(spacing.x * spacing.y);
    // Slopes of real ground make height minus z larger than the distance.
    Node ground = 0.8 * source(elevation.field);
    std::vector<OctaveSettings> layers;
    if (preset.crags > 0)
        layers.push_back(
            {.wavelength = 5 * post,
             .octaves = 4,
             .amplitude = preset.crags * post,
             .gain = 0.5,
             .seed = 11});
    layers.push_back(
        {.wavelength = 2 * post,
         .octaves = octavesFrom(2 * post),
         .amplitude = preset.relief * post,
         .gain = 0.5,
         .seed = 12});
    if (preset.caves > 0)
        ground = tunnels(
            ground,
            {.wavelength = 9 * post,
             .radius = preset.caves * post,
             .radiusVariation = 0.7,
             .depth = 4 * post,
             .rounding = 0.1 * post,
             .seed = 13});
    return detail(ground, layers);
}

} // namespace

const std::vector<LandscapePreset>& landscapePresets()
{
    static const std::vector<LandscapePreset> presets{
        {"natural", "Fine relief between the posts", 0.05, 0, 0},
        {"rugged", "Crags, overhangs and caves as well", 0.05, 0.6, 0.3}};
    return presets;
}

core::Result<std::shared_ptr<const fields::Field>>
landscape(const LoadedElevation& elevation, const LandscapeSettings& settings)
{
    std::string names;
    for (const LandscapePreset& preset : landscapePresets()) {
        if (preset.name == settings.preset)
            return std::make_shared<const Framed>(
                fields::graph::graphField(
                    nodeOf(elevation, preset),
                    {.seed = settings.seed, .filterStrength = settings.filterStrength}),
                elevation.dataBox);
        names += (names.empty() ? "" : ", ") + preset.name;
    }
    return core::failure(
        core::ErrorCode::usage,
        "there is no detail '" + settings.preset + "' for landscapes; choose one of " + names);
}

} // namespace isofront::elevation
