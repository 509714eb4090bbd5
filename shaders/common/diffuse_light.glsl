// What a light puts on a surface, and the part of it that leaves alike to all sides: what the eyes share.
// Needs what lights.glsl needs.
#ifndef DIFFUSE_LIGHT_GLSL
#define DIFFUSE_LIGHT_GLSL
#include "lights.glsl"

// `from_light`, to the bit. `diffuse`: times the albedo it is the diffuse part; Fresnel's share in it depends on v, but
// hardly.
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

#endif
