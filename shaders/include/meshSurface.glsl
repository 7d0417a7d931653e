// What a mesh's fragment hands to the shading pass.
#ifndef ISOFRONT_MESH_SURFACE_GLSL
#define ISOFRONT_MESH_SURFACE_GLSL

// The normal towards the eye's side of the surface; in w: 0.25 for a surface, 0.5 for a cap (the
// three vertices are caps), negative where the back is seen.
vec4 surfaceOf(vec4 normalAndCap, bool isFront)
{
    float kind = normalAndCap.w > 0.999 ? 0.5 : 0.25;
    return vec4(normalAndCap.xyz, isFront ? kind : -kind);
}

#endif
