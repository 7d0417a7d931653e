/** How a surface looks: one shader for all ways of looking at it. */
import { Color, DoubleSide, GLSL3, ShaderMaterial, Vector3, Vector4 } from 'three';

export const SHADINGS = ['surface', 'levels', 'normals'] as const;
export type Shading = (typeof SHADINGS)[number];

/** Balls that can be marked. */
export const MOST_MARKS = 64;

const VERTEX = /* glsl */ `
  in vec4 shape;
  in vec4 colour;
  out vec3 vNormal;
  out vec3 vFieldNormal;
  out vec3 vPosition;
  out vec3 vRelative;
  out vec4 vColour;
  flat out float vExponent;

  vec3 octahedral(vec2 code)
  {
    vec3 n = vec3(code, 1.0 - abs(code.x) - abs(code.y));
    float below = max(-n.z, 0.0);
    n.xy -= mix(-vec2(below), vec2(below), greaterThanEqual(n.xy, vec2(0.0)));
    return normalize(n);
  }

  void main()
  {
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    vFieldNormal = octahedral(shape.xy / 127.0);
    vNormal = normalMatrix * vFieldNormal;
    vPosition = seen.xyz;
    vRelative = (modelMatrix * vec4(position, 1.0)).xyz;
    vColour = colour;
    vExponent = shape.z;
    gl_Position = projectionMatrix * seen;
  }
`;

const FRAGMENT = /* glsl */ `
  uniform vec3 tint;
  uniform float opacity;
  uniform int look;         // 0 lit, 1 levels, 2 normals, 3 one colour
  uniform vec4 clip;        // what is before the plane is left out; relative to the eye
  uniform vec3 skyward;     // the scene's up, in the view's space
  uniform bool isLand;
  uniform int spotCount;
  uniform vec4 spots[${MOST_MARKS}]; // centre, relative to the eye, and radius
  in vec3 vNormal;
  in vec3 vFieldNormal;
  in vec3 vPosition;
  in vec3 vRelative;
  in vec4 vColour;
  flat in float vExponent;
  out vec4 result;

  vec3 linear(vec3 srgb)
  {
    return pow(srgb, vec3(2.2));
  }

  vec3 ofLevel(float exponent)
  {
    vec3 phase = vec3(0.0, 0.33, 0.67) + 0.381966 * exponent;
    return linear(0.66 + 0.24 * cos(6.2831853 * phase));
  }

  vec3 ofLand(float steepness)
  {
    vec3 grass = vec3(0.11, 0.15, 0.045);
    vec3 rock = vec3(0.24, 0.20, 0.165);
    return mix(grass, rock, smoothstep(0.12, 0.38, steepness));
  }

  void main()
  {
    if (dot(clip.xyz, vRelative) > clip.w)
      discard;
    vec3 n = normalize(vNormal);
    vec3 v = normalize(-vPosition);
    bool isInside = !gl_FrontFacing;
    if (isInside)
      n = -n;
    vec3 base = tint;
    if (look == 1)
      base = ofLevel(vExponent);
    else if (look == 2)
      base = linear(0.5 + 0.5 * normalize(vFieldNormal));
    else if (vColour.a > 0.0)
      base = linear(vColour.rgb);
    else if (isLand)
      base = ofLand(1.0 - dot(n, skyward));
    if (isInside && look < 2)
      base = mix(base, vec3(dot(base, vec3(0.33))), 0.35) * 0.55;
    vec3 light = base;
    if (look < 2) {
      vec3 key = normalize(vec3(-0.45, 0.65, 0.75));
      vec3 side = normalize(vec3(0.8, -0.1, 0.35));
      float sky = 0.5 + 0.5 * dot(n, skyward);
      float glance = 1.0 - abs(dot(n, v));
      vec3 half_ = normalize(key + v);
      light = base * (vec3(0.30, 0.33, 0.38) * sky + vec3(0.12, 0.11, 0.10));
      light += base * vec3(1.0, 0.97, 0.92) * 0.95 * max(dot(n, key), 0.0);
      light += base * vec3(0.6, 0.7, 0.9) * 0.18 * max(dot(n, side), 0.0);
      light += vec3(0.10) * pow(max(dot(n, half_), 0.0), 36.0) * (isLand ? 0.2 : 1.0);
      light *= 1.0 - 0.35 * glance * glance;
    }
    bool isMarked = false;
    for (int i = 0; i < spotCount; ++i)
      isMarked = isMarked || distance(vRelative, spots[i].xyz) < spots[i].w;
    if (isMarked)
      light = mix(light, vec3(0.05, 0.45, 0.5), 0.35);
    result = linearToOutputTexel(vec4(light, opacity));
  }
`;

/** Nothing is clipped. */
export const NO_CLIP = new Vector4(0, 0, 0, 1);

export function surfaceMaterial(): ShaderMaterial {
  return new ShaderMaterial({
    glslVersion: GLSL3,
    vertexShader: VERTEX,
    fragmentShader: FRAGMENT,
    side: DoubleSide,
    uniforms: {
      tint: { value: new Color() },
      opacity: { value: 1 },
      look: { value: 0 },
      clip: { value: NO_CLIP.clone() },
      skyward: { value: new Vector3(0, 1, 0) },
      isLand: { value: false },
      spotCount: { value: 0 },
      spots: { value: Array.from({ length: MOST_MARKS }, () => new Vector4()) },
    },
  });
}
