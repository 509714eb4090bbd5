// The share of a light that reaches a point, by one ray to a point of the light. A light's size softens its shadows and
// changes nothing else: the light is a disc about its centre that faces the point, and all of it has the strength of the
// centre.
// Needs what rays.glsl needs.
#ifndef SHADOW_GLSL
#define SHADOW_GLSL
#include "random.glsl"
#include "rays.glsl"

// How far off the surface's plane a ray to a light starts, as a share of the distance from the head. Rounding can put a point
// below its triangle by less than this.
const float SHADOW_OFFSET = 2e-4;

// Maps the unit square to the unit disc so that neighbours stay neighbours (Shirley & Chiu 1997).
vec2 on_disc(vec2 u) {
    vec2 p = 2.0 * u - 1.0;
    if (p.x == 0.0 && p.y == 0.0) return vec2(0.0);
    bool wide = abs(p.x) > abs(p.y);
    float r = wide ? p.x : p.y;
    float phi = wide ? 0.25 * PI * p.y / p.x : 0.5 * PI - 0.25 * PI * p.x / p.y;
    return r * vec2(cos(phi), sin(phi));
}

// `disc`: the point of the light, as a point of the unit disc.
vec3 light_share(LightData light, vec3 position, vec3 face_normal, vec2 disc) {
    if (light.casts_shadow == 0u) return vec3(1.0);
    vec3 origin = position + face_normal * (SHADOW_OFFSET * length(position));
    vec3 toward;
    // The ray ends just before the light, so that a surface on which the light lies does not hide it.
    float t_max = 1.0 - 1e-4;
    if (light.kind == 0u) {
        toward = -light.direction;
        if (light.size > 0.0) toward += basis(toward) * vec3(light.size * disc, 0.0);
        t_max = FLT_MAX;
    } else {
        toward = light.position - origin;
        float d = length(toward);
        // The disc is never wider than its distance from the point, not even for a point inside the light.
        if (light.size > 0.0 && d > 0.0) {
            toward += basis(toward / d) * vec3(min(light.size, 0.5 * d) * disc, 0.0);
        }
    }
    if (dot(toward, face_normal) <= 0.0) return vec3(0.0);
    return transmittance(origin, toward, t_max);
}

#endif
