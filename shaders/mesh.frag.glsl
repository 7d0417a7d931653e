#version 460

// Writes what the shading pass needs. Shading itself comes later, once a pixel: a rasteriser in
// software shades whole blocks for every small triangle, twenty fragments for each.
layout(location = 0) in vec4 normalAndCap;

// The normal towards the eye's side of the surface; in w: 0.25 for a surface, 0.5 for a cap (the
// three vertices are caps), negative where the back is seen.
layout(location = 0) out vec4 surface;

void main()
{
    float kind = normalAndCap.w > 0.999 ? 0.5 : 0.25;
    surface = vec4(normalAndCap.xyz, gl_FrontFacing ? kind : -kind);
}
