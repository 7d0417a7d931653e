#include "TerrainProgram.h"

// This file includes itself once for each instruction set; the order matters.
// clang-format off
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "TerrainKernel.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>
#include "simd/Batch-inl.h"
#include "simd/Noise-inl.h"
// clang-format on

HWY_BEFORE_NAMESPACE();
namespace isofront::fields::HWY_NAMESPACE {

namespace {

template <typename N, typename Octave>
HWY_INLINE N sumOf(const std::vector<Octave>& octaves, const Point<N>& p, const Radius& radius)
{
    return fractalSum(octaves.data(), octaves.size(), p, radius);
}

/// Ridges: each octave is sharp where its noise is zero, and only ridges carry further ridges, so
/// that valleys stay smooth.
/// Based on: Musgrave, Kolb, Mace, "The synthesis and rendering of eroded fractal terrains" (1989),
/// and Musgrave's ridged multifractal in "Texturing and Modeling". Differs: an octave is taken
/// about its mean, so that the filter takes its shape away and leaves the height.
template <typename N>
HWY_INLINE N ridged(const TerrainProgram& t, const Point<N>& p, const Radius& radius)
{
    constexpr float kSharpness = 0.004F;
    N height = fromConstant<N>(t.base);
    N carrier = fromConstant<N>(1.0F);
    for (const PlaneOctave& octave : t.ridges) {
        const N factor = weight<N>(radius, octave.filterCycles);
        // Higher octaves are filtered away as well, in the same lanes.
        if (vanishes(factor))
            break;
        const N noise = noiseAt(octave, p) * t.ridgeScale;
        const N crest = 1.0F - root(squared(noise) + kSharpness);
        const N signal = squared(most(crest, fromConstant<N>(0.0F)));
        height = height + (signal - t.ridgeMean) * carrier * factor * octave.amplitude;
        carrier = smoothStep(signal * t.ridgeGain * carrier, 0.0F, 1.0F);
    }
    return height;
}

template <typename N>
HWY_INLINE N mountains(const TerrainProgram& t, const Point<N>& p, const Radius& radius)
{
    const N peaks = ridged(t, p, radius);
    const N floor = sumOf(t.hills, p, radius) + t.floor;
    const N height = smoothMost(peaks, floor, 12.0F * t.rounding);
    return (height - asNumber(p.z)) * t.valuePerMetre;
}

template <typename N>
HWY_INLINE N canyons(const TerrainProgram& t, const Point<N>& p, const Radius& radius)
{
    const CanyonSettings& c = t.canyon;
    const N river = magnitude(sumOf(t.river, p, radius)) * c.riverMetres;
    const N side = magnitude(sumOf(t.sideRiver, p, radius)) * c.sideMetres;
    // A lower wall, a terrace, an upper wall; side canyons cut the plateau down to the terrace.
    const N wall = smoothStep(river, c.innerBegin, c.innerEnd) * c.innerShare +
                   smoothStep(river, c.outerBegin, c.outerEnd) * (1.0F - c.innerShare);
    const N cut = (1.0F - smoothStep(side, c.sideBegin, c.sideEnd)) * c.sideShare;
    const N height = wall * (1.0F - cut) * c.depth + sumOf(t.hills, p, radius) + c.floor;
    return (height - asNumber(p.z)) * t.valuePerMetre;
}

template <typename N>
HWY_INLINE N floatingIslands(const TerrainProgram& t, const Point<N>& p, const Radius& radius)
{
    N land = fromConstant<N>(-4e4F);
    const N z = asNumber(p.z);
    for (const IslandProgram& level : t.islands) {
        const N shape = sumOf(level.shape, p, radius) - level.threshold;
        const N rim = z - (sumOf(level.elevation, p, radius) + level.altitude);
        // Where the shape is negative the bottom lies above the top: no land.
        const N below = shape * level.top - rim;
        const N above = rim + shape * level.bottom;
        land = most(land, smoothLeast(below, above, 4.0F * t.rounding));
    }
    return (land + sumOf(t.hills, p, radius)) * t.valuePerMetre;
}

/// Adds octaves of detail. An octave is faded out where the value is already so far from zero that
/// this and all later octaves can't change its sign: there it costs nothing.
template <typename N>
HWY_NOINLINE N detailed(
    N value,
    const std::vector<DetailOctave>& octaves,
    const N& strength,
    const Point<N>& p,
    const Radius& radius)
{
    for (const DetailOctave& octave : octaves) {
        const N factor = weight<N>(radius, octave.noise.filterCycles);
        const N near =
            (1.0F - smoothStep(magnitude(value), octave.remaining, 2.0F * octave.remaining)) *
            factor;
        if (vanishes(near))
            continue;
        value = value + noiseAt(octave.noise, p) * octave.noise.amplitude * near * strength;
    }
    return value;
}

/// Cuts tunnels out of the rock, down to some depth. Nothing changes where the value is so low that
/// no tunnel could lower it further, nor where it is deep below all tunnels.
template <typename N>
HWY_INLINE N tunnelled(
    const TerrainProgram& t,
    const TunnelProgram& tunnel,
    const N& value,
    const Point<N>& p,
    const Radius& radius)
{
    const N open = weight<N>(radius, tunnel.closingCycles) * 1.25F - 0.25F;
    const float widest = tunnel.radius * (1.0F + kSpaceNoise.magnitude * tunnel.radiusVariation);
    const float far = 3.0F * widest;
    // Inside the layer between: 1, elsewhere 0; the joins below make both ends exact.
    const N above = smoothStep(value, -widest - t.rounding, -widest - t.rounding + 1.0F);
    const N under =
        1.0F -
        smoothStep(value, tunnel.depth + far + t.rounding, tunnel.depth + far + t.rounding + 1.0F);
    if (vanishes(above * under))
        return smoothLeast(value, most(fromConstant<N>(far), value - tunnel.depth), t.rounding);
    const N a = noiseAt(tunnel.first, p) * tunnel.metresPerUnit;
    const N b = noiseAt(tunnel.second, p) * tunnel.metresPerUnit;
    const N wide =
        (noiseAt(tunnel.width, p) * tunnel.radiusVariation + 1.0F) * tunnel.radius * open;
    const N axis = root(squared(a) + squared(b) + 1.0F);
    const N distance = least(axis - wide, fromConstant<N>(far));
    return smoothLeast(value, most(distance, value - tunnel.depth), t.rounding);
}

struct Terrain {
    const TerrainProgram& program;

    template <typename N>
    HWY_INLINE N at(const Point<N>& p, const Radius& radius) const
    {
        const TerrainProgram& t = program;
        const Point<N> warped{
            p.x + sumOf(t.warpX, p, radius), p.y + sumOf(t.warpY, p, radius), p.z};
        N value = t.form == TerrainForm::mountains ? mountains(t, warped, radius)
                  : t.form == TerrainForm::canyon  ? canyons(t, warped, radius)
                                                   : floatingIslands(t, warped, radius);
        if (!t.crags.empty()) {
            const N mask = smoothStep(noiseAt(t.cragMask, p), -0.3F, 0.3F);
            value = detailed(value, t.crags, mask * (1.0F - t.cragLeast) + t.cragLeast, p, radius);
        }
        for (const TunnelProgram& tunnel : t.tunnels)
            value = tunnelled(t, tunnel, value, p, radius);
        // Adding zero turns a negative zero, which skipped octaves leave, into a positive one.
        return detailed(value, t.fine, fromConstant<N>(1.0F), p, radius) + 0.0F;
    }
};

} // namespace

void sampleTerrainOn(const TerrainProgram& program, const SampleBatch& batch, float* values)
{
    sampleBatch(Terrain{program}, batch, values);
}

void gradientTerrainOn(
    const TerrainProgram& program, const SampleBatch& batch, const GradientSpans& gradients)
{
    gradientBatch(Terrain{program}, batch, nullptr, gradients);
}

core::Interval
boundTerrainOn(const TerrainProgram& program, const core::Box& box, const core::Interval& radius)
{
    // Rounding: heights of some kilometres in float, and a few dozen operations.
    return boundsOver(Terrain{program}, box, radius, 0.02);
}

} // namespace isofront::fields::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace isofront::fields {

HWY_EXPORT(sampleTerrainOn);
HWY_EXPORT(gradientTerrainOn);
HWY_EXPORT(boundTerrainOn);

void sampleTerrain(const TerrainProgram& program, const SampleBatch& batch, std::span<float> values)
{
    HWY_DYNAMIC_DISPATCH(sampleTerrainOn)(program, batch, values.data());
}

void gradientTerrain(
    const TerrainProgram& program, const SampleBatch& batch, const GradientSpans& gradients)
{
    HWY_DYNAMIC_DISPATCH(gradientTerrainOn)(program, batch, gradients);
}

core::Interval
boundTerrain(const TerrainProgram& program, const core::Box& box, const core::Interval& radius)
{
    return HWY_DYNAMIC_DISPATCH(boundTerrainOn)(program, box, radius);
}

} // namespace isofront::fields
#endif
