#include "Octaves.h"

#include <isofront/core/Hash.h>

#include <algorithm>

namespace isofront::fields {

namespace {

/// A number in [0, 1), the same on every machine.
double unitNumber(std::uint64_t word)
{
    return static_cast<double>(word >> 11U) * 0x1p-53;
}

// Far enough that octaves have nothing to do with one another, near enough that no bits of the
// fraction are lost.
constexpr double kOffsetRange = 1024.0;

} // namespace

std::vector<SpaceOctave>
spaceOctaves(const FractalSettings& settings, std::uint64_t seed, double filterStrength)
{
    std::vector<SpaceOctave> octaves;
    double frequency = 1.0 / settings.wavelength;
    double amplitude = settings.amplitude;
    for (int i = 0; i < settings.octaves; ++i) {
        const std::uint64_t key = core::hashCombined(core::mixed(seed), std::uint64_t(i) + 1);
        SpaceOctave octave{};
        for (int axis = 0; axis < 3; ++axis) {
            octave.frequency[axis] = axis == 2 ? frequency * settings.stretch : frequency;
            octave.offset[axis] =
                kOffsetRange * unitNumber(core::hashCombined(key, std::uint64_t(axis) + 1));
        }
        octave.amplitude = static_cast<float>(amplitude);
        octave.filterCycles =
            static_cast<float>(filterStrength * std::max(frequency, frequency * settings.stretch));
        octave.seed = static_cast<std::uint32_t>(core::hashCombined(key, 7));
        octaves.push_back(octave);
        frequency *= settings.lacunarity;
        amplitude *= settings.gain;
    }
    return octaves;
}

std::vector<PlaneOctave> planeOctaves(
    const FractalSettings& settings, std::uint64_t seed, double filterStrength, NoiseKind kind)
{
    // 3 / 5 and 4 / 5 turn by 36.87 degrees, no rational part of a circle, and need no sine.
    constexpr double kCosine = 0.8;
    constexpr double kSine = 0.6;
    std::vector<PlaneOctave> octaves;
    double frequency = 1.0 / settings.wavelength;
    double amplitude = settings.amplitude;
    double cosine = kCosine;
    double sine = kSine;
    for (int i = 0; i < settings.octaves; ++i) {
        const std::uint64_t key = core::hashCombined(core::mixed(~seed), std::uint64_t(i) + 1);
        PlaneOctave octave{};
        octave.first[0] = frequency * cosine;
        octave.first[1] = frequency * sine;
        octave.second[0] = -frequency * sine;
        octave.second[1] = frequency * cosine;
        if (kind == NoiseKind::simplex) {
            // From square coordinates to those along two edges of triangles, of length sqrt(2/3).
            constexpr double kAlong = 1.224744871391589;   // sqrt(3/2)
            constexpr double kAcross = 0.7071067811865476; // sqrt(1/2)
            for (int axis = 0; axis < 2; ++axis) {
                octave.first[axis] = kAlong * octave.first[axis] - kAcross * octave.second[axis];
                octave.second[axis] = 2 * kAcross * octave.second[axis];
            }
        }
        for (int axis = 0; axis < 2; ++axis)
            octave.offset[axis] =
                kOffsetRange * unitNumber(core::hashCombined(key, std::uint64_t(axis) + 1));
        octave.amplitude = static_cast<float>(amplitude);
        octave.filterCycles = static_cast<float>(filterStrength * frequency);
        octave.seed = static_cast<std::uint32_t>(core::hashCombined(key, 7));
        octaves.push_back(octave);
        frequency *= settings.lacunarity;
        amplitude *= settings.gain;
        const double turned = cosine * kCosine - sine * kSine;
        sine = cosine * kSine + sine * kCosine;
        cosine = turned;
    }
    return octaves;
}

} // namespace isofront::fields
