// Radiance on its way into an fp16 image: NaNs are counted and stored as 0; what fp16 cannot hold is counted and clamped.
// Needs `counters` (CountersData) from the includer.
#ifndef STORE_GLSL
#define STORE_GLSL

vec3 storable(vec3 radiance) {
    if (any(isnan(radiance))) {
        atomicAdd(counters.nan, 1u);
        return vec3(0.0);
    }
    if (any(isinf(radiance))) atomicAdd(counters.inf, 1u);
    // `>=`: emission has been clamped to 65504 already.
    if (any(greaterThanEqual(radiance, vec3(65504.0)))) atomicAdd(counters.clamped, 1u);
    return clamp(radiance, vec3(0.0), vec3(65504.0));
}

#endif
