#include "isofront/fields/Terrain.h"

#include "PresetTexts.h"

#include <isofront/core/Assert.h>

#include <algorithm>

namespace isofront::fields {

const std::vector<TerrainPreset>& terrainPresets()
{
    static const std::vector<TerrainPreset> presets = [] {
        std::vector<TerrainPreset> all;
        for (const PresetText& text : presetTexts()) {
            if (text.name == kExamplePreset)
                continue;
            const core::Result<TerrainPreset> preset =
                graph::parsePreset(text.json, std::string(text.name));
            ISOFRONT_ASSERT(preset.has_value(), preset.error().message);
            if (preset)
                all.push_back(*preset);
        }
        return all;
    }();
    return presets;
}

core::Result<TerrainPreset>
terrainPreset(const std::string& nameOrPath, const graph::FileLoader& load)
{
    std::string names;
    for (const TerrainPreset& preset : terrainPresets()) {
        if (preset.name == nameOrPath)
            return preset;
        names += (names.empty() ? "" : ", ") + preset.name;
    }
    if (nameOrPath.ends_with(".json"))
        return graph::readPreset(nameOrPath, load);
    return core::failure(
        core::ErrorCode::usage,
        "there is no terrain preset '" + nameOrPath + "'; choose one of " + names +
            ", or give the path of a .json file");
}

std::shared_ptr<const Field>
terrain(const TerrainPreset& preset, std::uint64_t seed, double filterStrength)
{
    return graph::fieldOf(preset, {.seed = seed, .filterStrength = filterStrength});
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
    const double precision = step / 40;
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
        while (empty - solid > precision) {
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
