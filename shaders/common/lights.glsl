// The light that arrives at a surface from punctual lights, and the light that leaves it towards v. Needs LightData of
// shared.glsl.
#ifndef LIGHTS_GLSL
#define LIGHTS_GLSL
#include "brdf.glsl"
#include "surface.glsl"

// Punctual lights have no size, so that a mirror would not show them. Their highlights are computed with at least this
// roughness.
const float PUNCTUAL_ROUGHNESS = 0.1;
// The least squared distance of a light, in square metres; a nearer light is treated as being that far away.
#ifndef NEAREST_SQUARED
#define NEAREST_SQUARED 1e-8
#endif
// More than any target can hold, and still finite after the multiplication by the lobe (at most 1/(4π α²)) and a sum over
// lights.
const float MOST_IRRADIANCE = 1e30;

// Irradiance on a surface facing the light, and the direction towards it.
vec3 incident(LightData light, vec3 position, out vec3 l) {
    if (light.kind == 0u) {
        l = -light.direction;
        return min(light.color, vec3(MOST_IRRADIANCE));
    }
    vec3 to_light = light.position - position;
    float d2 = max(dot(to_light, to_light), NEAREST_SQUARED);
    l = to_light * inversesqrt(d2);
    // The range's window function of KHR_lights_punctual.
    float q = d2 / square(light.range);
    float window = clamp(1.0 - q * q, 0.0, 1.0);
    float cone = 1.0;
    if (light.kind == 2u) {
        float c = dot(light.direction, -l);
        cone = square(clamp((c - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4), 0.0, 1.0));
    }
    return min(light.color * (window * cone / d2), vec3(MOST_IRRADIANCE));
}

// The outgoing light of one light without shadows. `diffuse`: the diffuse part of it, without the albedo. Its Fresnel factor
// depends on v, but only slightly.
vec3 from_light_with_diffuse(LightData light, Surface s, vec3 position, vec3 v, out vec3 diffuse) {
    diffuse = vec3(0.0);
    vec3 l;
    vec3 e = incident(light, position, l);
    float nl = dot(s.normal, l);
    if (nl <= 0.0) return vec3(0.0);
    float alpha = square(max(s.roughness, PUNCTUAL_ROUGHNESS));
    vec3 f = schlick(s.f0, max(dot(v, normalize_or(v + l, s.normal)), 0.0));
    diffuse = e * (1.0 - f) * (nl / PI);
    return e * (s.albedo * (1.0 - f) * (nl / PI) + ggx_times_cosine(s.normal, v, l, alpha, s.f0));
}

vec3 from_light(LightData light, Surface s, vec3 position, vec3 v) {
    vec3 diffuse;
    return from_light_with_diffuse(light, s, position, v, diffuse);
}

#endif
