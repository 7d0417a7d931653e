#version 460
#extension GL_GOOGLE_include_directive : require

// A landscape under a sky: rock in layers, grass, scree and snow, seen through the air.
#include "include/atmosphere.glsl"
#include "include/noise.glsl"
#include "include/shading.glsl"
#include "include/shadow.glsl"

struct Ground {
    vec3 albedo;
    vec3 normal;
};

// @param fromEye  [m]
// @param height   above the base [m]
Ground groundAt(vec3 fromEye, float height, float footprint, vec3 normal)
{
    vec3 up = frame.up.xyz;
    Texture t = textureAt(frame.eyePhase.xyz, fromEye, footprint, frame.heights.w);
    float slope = dot(normal, up);
    float steep = 1.0 - smoothstep(0.55, 0.85, slope);

    // Roughness that the triangles don't carry, strongest on bare rock.
    vec3 bump = t.bump - dot(t.bump, normal) * normal;
    vec3 bumped = normalize(normal - bump * mix(0.12, 0.20, steep));

    // Layers follow the height, bent a little; thin ones within thick ones.
    float thickness = frame.heights.z;
    float bent = height + 14.0 * t.broad + 1.5 * t.middle;
    float thick = layerNoise(bent / thickness) - 0.5;
    float thin = layerNoise(bent * 5.0 / thickness + 31.0) - 0.5;
    thick *= shownShare(footprint, thickness);
    thin *= shownShare(footprint, 0.2 * thickness) * steep;
    vec3 rock = mix(frame.colours[0].rgb, frame.colours[1].rgb, clamp(0.5 + 1.6 * thick, 0.0, 1.0));
    rock *= 0.92 + 0.45 * thin + 0.18 * t.broad + 0.32 * t.middle + 0.45 * t.fine;

    vec3 scree = frame.colours[3].rgb * (1.0 + 0.15 * t.broad + 0.22 * t.middle + 0.60 * t.fine);
    // Grass is dry in places and gives way to bushes in others.
    float dry = smoothstep(-0.1, 0.5, t.broad + 0.4 * t.middle);
    float bushes = smoothstep(0.0, 0.5, 0.6 * t.middle - 0.5 * t.broad + 0.35 * t.fine);
    vec3 grass = frame.colours[2].rgb * mix(vec3(1.0), vec3(1.9, 1.35, 1.25), dry);
    grass *= 1.0 + 0.20 * t.middle + 0.60 * t.fine;
    grass = mix(grass, frame.colours[2].rgb * vec3(0.45, 0.55, 0.6), 0.7 * bushes);
    vec3 snow = frame.colours[4].rgb * (0.98 + 0.03 * t.middle);

    float ragged = 0.09 * t.broad + 0.09 * t.middle + 0.10 * t.fine;
    float screeHere = smoothstep(0.60, 0.76, slope + ragged);
    float grassLine = frame.heights.x * (1.0 + 0.35 * t.broad + 0.10 * t.middle);
    float grassHere = smoothstep(0.72, 0.84, slope + ragged) *
                      (1.0 - smoothstep(0.80, 1.10, height / max(grassLine, 1.0)));
    float snowLine = frame.heights.y * (1.0 + 0.18 * t.broad + 0.08 * t.middle);
    float snowHere = smoothstep(0.94, 1.10, height / max(snowLine, 1.0)) *
                     smoothstep(0.55, 0.70, slope + ragged);

    vec3 albedo = mix(rock, scree, screeHere);
    albedo = mix(albedo, grass, grassHere);
    albedo = mix(albedo, snow, snowHere);
    return Ground(albedo, normalize(mix(bumped, normal, 0.75 * snowHere)));
}

// @param shares  of the sun's and of the sky's light that reach it
vec3 litGround(Ground ground, vec2 shares)
{
    vec3 up = frame.up.xyz;
    float toSun = dot(ground.normal, frame.sunDirection.xyz);
    // A little light reaches round the edge, as on real, rough ground.
    float direct = max(toSun, 0.0) * 0.92 + 0.08 * smoothstep(-0.3, 1.0, toSun);
    float above = 0.5 + 0.5 * dot(ground.normal, up);
    vec3 ambient = (frame.skyLight.rgb * above + frame.groundLight.rgb * (1.0 - above)) * shares.y;
    return ground.albedo * (frame.sunLight.rgb * (direct * shares.x / kPi) + ambient);
}

vec3 lightOf(Seen seen)
{
    vec3 ray = pixelRay(seen.at);
    vec3 direction = normalize(ray);
    if (seen.depth <= 0.0)
        return toneMapped(skyLight(direction) + sunDisc(direction));

    vec4 surface = seen.surface;
    vec3 normal = normalize(surface.w < 0.0 ? -surface.xyz : surface.xyz);
    vec3 fromEyeInWorld = ray * rayLength(seen.depth);
    vec3 fromEye = fromEyeInWorld * frame.up.w;
    float distance = length(fromEye);
    float height = frame.eyePhase.w + dot(fromEye, frame.up.xyz);
    float footprint = distance * frame.rayForward.w;

    Ground ground = isColoured(surface.w) ? Ground(ownAlbedo(seen), normal)
                                          : groundAt(fromEye, height, footprint, normal);
    vec3 light = litGround(ground, lightShares(fromEyeInWorld, normal));
    vec3 kept = transmittance(distance, frame.eyePhase.w, height);
    light = light * kept + scatteredLight(direction) * (1.0 - kept);
    return toneMapped(light);
}
