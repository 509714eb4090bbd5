// The outgoing reflection from the incoming light that the taps know: adds the fallback's share and multiplies by the lobe's
// albedo.
// Needs `frame`, `specular_map` and `brdf_table` from the includer.
#ifndef OUTGOING_GLSL
#define OUTGOING_GLSL
#include "pair.glsl"

// (C·L + (1 − C)·fallback)·(F0·A + B). known: C·L, the known share of the incoming light; confidence: C.
vec3 outgoing(Pixel p, vec3 known, float confidence) {
    float nv = max(dot(p.surface.normal, p.v), 1e-4);
    if (frame.fallback != 0u) {
        known += (1.0 - confidence) * environment_specular(reflect(-p.v, p.surface.normal), p.surface.roughness);
    }
    return known * specular_albedo(p.surface.f0, nv, p.surface.roughness);
}

#endif
