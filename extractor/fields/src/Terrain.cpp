#include "isofront/fields/Terrain.h"

#include "TerrainProgram.h"

#include <isofront/core/Assert.h>
#include <isofront/core/Hash.h>

#include <algorithm>
#include <cmath>

namespace isofront::fields {

namespace {

FractalSettings fractal(const TerrainOctaves& settings)
{
    return {
        .wavelength = settings.wavelength,
        .octaves = settings.octaves,
        .amplitude = settings.amplitude,
        .lacunarity = settings.lacunarity,
        .gain = settings.gain,
        .stretch = settings.stretch};
}

/// Draws the octaves of a preset. Every part takes the next seed, so that parts don't line up.
class Drawing {
public:
    Drawing(std::uint64_t seed, double filterStrength)
        : _seed(core::mixed(seed)), _filterStrength(filterStrength)
    {
    }

    std::vector<SpaceOctave> space(const TerrainOctaves& settings)
    {
        return spaceOctaves(fractal(settings), next(), _filterStrength);
    }
    std::vector<PlaneOctave> plane(const TerrainOctaves& settings)
    {
        return planeOctaves(fractal(settings), next(), _filterStrength);
    }
    [[nodiscard]] double filterStrength() const { return _filterStrength; }

private:
    std::uint64_t next() { return core::hashCombined(_seed, ++_part); }

    std::uint64_t _seed;
    std::uint64_t _part = 0;
    double _filterStrength;
};

/// From the strongest octave to the weakest, each with the sum of what follows.
std::vector<DetailOctave> detailOf(std::vector<SpaceOctave> octaves, double after)
{
    std::stable_sort(
        octaves.begin(), octaves.end(), [](const SpaceOctave& a, const SpaceOctave& b) {
            return a.amplitude > b.amplitude;
        });
    std::vector<DetailOctave> detail(octaves.size());
    double remaining = after;
    for (std::size_t i = octaves.size(); i-- > 0;) {
        remaining += double(kSpaceNoise.magnitude) * double(octaves[i].amplitude);
        detail[i] = {octaves[i], static_cast<float>(remaining)};
    }
    return detail;
}

TunnelProgram tunnelOf(const TunnelSettings& settings, Drawing& drawing)
{
    const auto sheet = [&](double scale) {
        return drawing
            .space(
                {.wavelength = scale * settings.wavelength,
                 .octaves = 1,
                 .amplitude = 1,
                 .stretch = settings.stretch})
            .front();
    };
    TunnelProgram tunnel{};
    tunnel.first = sheet(1.0);
    tunnel.second = sheet(1.13);
    tunnel.width = sheet(0.61);
    // Where gradient noise is zero its slope is about 1.2 a cell.
    tunnel.metresPerUnit = static_cast<float>(0.8 * settings.wavelength);
    tunnel.radius = static_cast<float>(settings.radius);
    tunnel.radiusVariation = static_cast<float>(settings.radiusVariation);
    tunnel.depth = static_cast<float>(settings.depth);
    tunnel.closingCycles = static_cast<float>(drawing.filterStrength() / (4.0 * settings.radius));
    return tunnel;
}

constexpr float kRidgeScale = 2.2F;
/// The mean of the squared crest over the plane, measured.
constexpr float kRidgeMean = 0.4F;

TerrainProgram programOf(const TerrainPreset& preset, std::uint64_t seed, double filterStrength)
{
    Drawing drawing(seed, filterStrength);
    TerrainProgram program;
    program.form = preset.form;
    program.valuePerMetre = static_cast<float>(preset.valuePerMetre);
    program.rounding = static_cast<float>(preset.rounding);
    program.warpX = drawing.space(preset.warp);
    program.warpY = drawing.space(preset.warp);

    const RidgeSettings& mountains = preset.mountains;
    program.ridges = drawing.plane(mountains.ridges);
    program.hills = drawing.plane(mountains.hills);
    program.ridgeScale = kRidgeScale;
    program.ridgeMean = kRidgeMean;
    program.ridgeGain = static_cast<float>(mountains.gain);
    program.base = static_cast<float>(mountains.base);
    program.floor = static_cast<float>(mountains.floor);

    program.river = drawing.plane(preset.canyon.river);
    program.sideRiver = drawing.plane(preset.canyon.sideRiver);
    program.canyon = preset.canyon;

    for (const IslandLevel& level : preset.islands)
        program.islands.push_back(
            {drawing.plane(level.shape),
             drawing.plane(level.elevation),
             static_cast<float>(level.altitude),
             static_cast<float>(level.threshold),
             static_cast<float>(level.top),
             static_cast<float>(level.bottom)});

    program.fine = detailOf(drawing.space(preset.fine), 0.0);
    const double fineReach = program.fine.empty() ? 0.0 : double(program.fine.front().remaining);
    std::vector<SpaceOctave> crags;
    for (const TerrainOctaves& settings : preset.crags) {
        const std::vector<SpaceOctave> drawn = drawing.space(settings);
        crags.insert(crags.end(), drawn.begin(), drawn.end());
    }
    program.crags = detailOf(std::move(crags), fineReach);
    program.cragLeast = static_cast<float>(preset.cragLeast);
    program.cragMask = drawing.plane({.wavelength = 3100, .octaves = 1, .amplitude = 1}).front();
    for (const TunnelSettings& settings : preset.tunnels)
        program.tunnels.push_back(tunnelOf(settings, drawing));
    return program;
}

class Terrain final : public Field {
public:
    Terrain(const TerrainPreset& preset, std::uint64_t seed, double filterStrength)
        : _program(programOf(preset, seed, filterStrength))
    {
    }

    void sample(const SampleBatch& batch, std::span<float> values) const override
    {
        ISOFRONT_ASSERT(values.size() == batch.size(), "as many values as points");
        sampleTerrain(_program, batch, values);
    }
    void gradient(const SampleBatch& batch, GradientSpans gradients) const override
    {
        gradientTerrain(_program, batch, gradients);
    }
    core::Interval bounds(const core::Box& box, core::Interval radius) const override
    {
        return boundTerrain(_program, box, radius);
    }
    double differenceStep(double radius) const override { return std::max(0.5 * radius, 0.05); }

private:
    TerrainProgram _program;
};

} // namespace

core::Result<TerrainPreset> terrainPreset(const std::string& name)
{
    std::string names;
    for (const TerrainPreset& preset : terrainPresets()) {
        if (preset.name == name)
            return preset;
        names += (names.empty() ? "" : ", ") + preset.name;
    }
    return core::failure(
        core::ErrorCode::usage,
        "there is no terrain preset '" + name + "'; choose one of " + names);
}

std::shared_ptr<const Field>
terrain(const TerrainPreset& preset, std::uint64_t seed, double filterStrength)
{
    return std::make_shared<Terrain>(preset, seed, filterStrength);
}

core::Result<std::shared_ptr<const Field>> makeTerrain(const TerrainSettings& settings)
{
    return terrainPreset(settings.preset).map([&](const TerrainPreset& preset) {
        return terrain(preset, settings.seed, settings.filterStrength);
    });
}

std::shared_ptr<const Field> terrain(const TerrainSettings& settings)
{
    const core::Result<std::shared_ptr<const Field>> made = makeTerrain(settings);
    ISOFRONT_ASSERT(made.has_value(), "there is no terrain preset '" + settings.preset + "'");
    return made.value_or(nullptr);
}

double surfaceHeight(const Field& field, const core::Box& box, double x, double y, double step)
{
    constexpr std::size_t kBlock = 128;
    constexpr double kPrecision = 0.1; // [m]
    std::vector<double> xs(kBlock, x);
    std::vector<double> ys(kBlock, y);
    std::vector<double> zs(kBlock);
    std::vector<float> values(kBlock);
    for (double top = box.high.z; top > box.low.z; top -= step * double(kBlock)) {
        for (std::size_t i = 0; i < kBlock; ++i)
            zs[i] = top - step * double(i);
        field.sample({xs, ys, zs}, values);
        const auto hit =
            std::find_if(values.begin(), values.end(), [](float value) { return value >= 0; });
        if (hit == values.end())
            continue;
        double solid = zs[static_cast<std::size_t>(hit - values.begin())];
        double empty = std::min(solid + step, box.high.z);
        while (empty - solid > kPrecision) {
            const double middle = 0.5 * (solid + empty);
            float value = 0;
            field.sample({{&x, 1}, {&y, 1}, {&middle, 1}}, {&value, 1});
            (value >= 0 ? solid : empty) = middle;
        }
        return std::clamp(solid, box.low.z, box.high.z);
    }
    return box.low.z;
}

} // namespace isofront::fields
