#version 460
#extension GL_GOOGLE_include_directive : require

// A landscape under a sky: rock in layers, grass, scree and snow, seen through the air.
#include "include/atmosphere.glsl"
#include "include/noise.glsl"
#include "include/shading.glsl"

struct Ground {
    vec3 albedo;
    vec3 normal;
};

// @param fromEye  [m]
// @param height   above the base [m]
Ground groundAt(vec3 fromEye, float height, float footprint, vec3 normal)
{
    vec3 phase = frame.eyePhase.xyz;
    vec3 up = frame.up.xyz;
    float broad = octave(phase, fromEye, 256.0, footprint).x;
    float middle = octave(phase, fromEye, 32.0, footprint).x;
    vec4 fine = octave(phase, fromEye, 4.0, footprint);
    vec4 grain = octave(phase, fromEye, 0.5, footprint);
    float patches = 0.6 * broad + 0.3 * middle + 0.1 * fine.x;

    // Roughness that the triangles don't carry, strongest on bare rock.
    float slope = dot(normal, up);
    float bare = 1.0 - smoothstep(0.6, 0.85, slope);
    vec3 bump = (0.35 * fine.yzw + 0.25 * grain.yzw) * (0.25 + 0.75 * bare);
    vec3 bumped = normalize(normal - (bump - dot(bump, normal) * normal) * 0.5);
    float rough = dot(bumped, up);

    // Layers follow the height, bent a little.
    float thickness = frame.heights.z;
    float layer = (height + 10.0 * broad + 2.5 * middle) / thickness;
    float bands = 0.5 + 0.5 * sin(6.2831853 * layer) * sin(2.71 * layer + 1.3);
    bands *= 1.0 - smoothstep(0.2, 0.6, footprint / thickness);
    vec3 rock = mix(frame.colours[0].rgb, frame.colours[1].rgb, smoothstep(0.25, 0.75, bands));
    rock *= 0.85 + 0.25 * patches + 0.2 * fine.x + 0.15 * grain.x;

    vec3 scree = frame.colours[3].rgb * (0.9 + 0.2 * middle + 0.25 * grain.x);
    vec3 grass = frame.colours[2].rgb * (1.0 + 0.35 * patches + 0.25 * fine.x + 0.2 * grain.x);
    grass = mix(grass, grass * vec3(1.9, 1.45, 1.1), smoothstep(0.0, 0.6, patches + 0.3 * middle));
    vec3 snow = frame.colours[4].rgb * (0.97 + 0.03 * middle);

    float screeHere = smoothstep(0.55, 0.72, rough + 0.12 * middle);
    float grassLine = frame.heights.x * (1.0 + 0.25 * broad + 0.08 * middle);
    float grassHere = smoothstep(0.68, 0.82, slope + 0.1 * middle + 0.05 * fine.x) *
                      (1.0 - smoothstep(0.85, 1.1, height / grassLine));
    float snowLine = frame.heights.y * (1.0 + 0.15 * broad + 0.06 * middle);
    float snowHere = smoothstep(0.95, 1.12, height / snowLine) *
                     smoothstep(0.45, 0.62, slope + 0.08 * middle + 0.05 * fine.x);

    vec3 albedo = mix(rock, scree, screeHere);
    albedo = mix(albedo, grass, grassHere);
    albedo = mix(albedo, snow, snowHere);
    vec3 shadingNormal = normalize(mix(bumped, normal, 0.8 * snowHere));
    return Ground(albedo, shadingNormal);
}

vec3 litGround(Ground ground, float shadow, float openness)
{
    vec3 up = frame.up.xyz;
    float toSun = dot(ground.normal, frame.sunDirection.xyz);
    // A little light reaches round the edge, as on real, rough ground.
    float direct = max(toSun, 0.0) * 0.92 + 0.08 * smoothstep(-0.3, 1.0, toSun);
    float above = 0.5 + 0.5 * dot(ground.normal, up);
    vec3 ambient = (frame.skyLight.rgb * above + frame.groundLight.rgb * (1.0 - above)) * openness;
    return ground.albedo * (frame.sunLight.rgb * (direct * shadow / kPi) + ambient);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(depthImage, pixel, 0).r;
    vec3 ray = pixelRay(gl_FragCoord.xy);
    vec3 direction = normalize(ray);
    if (depth <= 0.0) {
        if (frame.backdrop.w > 0.0) {
            colour = vec4(encoded(frame.backdrop.rgb), 1.0);
            return;
        }
        colour = finished(skyLight(direction) + sunDisc(direction));
        return;
    }

    vec4 surface = texelFetch(surfaceImage, pixel, 0);
    vec3 normal = normalize(surface.w < 0.0 ? -surface.xyz : surface.xyz);
    vec3 fromEye = ray * (rayLength(depth) * frame.up.w);
    float distance = length(fromEye);
    float height = frame.eyePhase.w + dot(fromEye, frame.up.xyz);
    float footprint = distance * frame.rayForward.w;

    Ground ground = groundAt(fromEye, height, footprint, normal);
    vec3 light = litGround(ground, 1.0, 1.0);
    vec3 kept = transmittance(distance, frame.eyePhase.w, height);
    light = light * kept + scatteredLight(direction) * (1.0 - kept);
    colour = finished(light);
}
