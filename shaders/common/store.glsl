// Radiance on its way into an fp16 image: counted when it is not a number, clamped and counted when too large.
// Needs `counters` (CountersData) from the includer.
#ifndef STORE_GLSL
#define STORE_GLSL

vec3 storable(vec3 radiance) {
    if (any(isnan(radiance))) {
        atomicAdd(counters.nan, 1u);
        return vec3(0.0);
    }
    if (any(isinf(radiance))) atomicAdd(counters.inf, 1u);
    // Emission arrives cut at 65504 already.
    if (any(greaterThanEqual(radiance, vec3(65504.0)))) atomicAdd(counters.clamped, 1u);
    return clamp(radiance, vec3(0.0), vec3(65504.0));
}

#endif
