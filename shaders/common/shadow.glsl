// Which share of a light reaches a point, by one ray to a point of the light. Its size softens the shadow and nothing
// else: a light shines from a disc about its centre, seen from the point, with the strength that its centre has.
// Needs what rays.glsl needs.
#ifndef SHADOW_GLSL
#define SHADOW_GLSL
#include "random.glsl"
#include "rays.glsl"

// How far off its plane a ray to a light starts, as a share of the distance from the head: more than what rounding can
// put a point below its triangle.
const float SHADOW_OFFSET = 2e-4;

// From the unit square to the unit disc (Shirley & Chiu 1997), neighbours to neighbours.
vec2 on_disc(vec2 u) {
    vec2 p = 2.0 * u - 1.0;
    if (p.x == 0.0 && p.y == 0.0) return vec2(0.0);
    bool wide = abs(p.x) > abs(p.y);
    float r = wide ? p.x : p.y;
    float phi = wide ? 0.25 * PI * p.y / p.x : 0.5 * PI - 0.25 * PI * p.x / p.y;
    return r * vec2(cos(phi), sin(phi));
}

// `disc`: which point of the light, on the unit disc.
vec3 light_share(LightData light, vec3 position, vec3 face_normal, vec2 disc) {
    if (light.casts_shadow == 0u) return vec3(1.0);
    vec3 origin = position + face_normal * (SHADOW_OFFSET * length(position));
    vec3 toward;
    // The matter that a light stands on does not hide it.
    float t_max = 1.0 - 1e-4;
    if (light.kind == 0u) {
        toward = -light.direction;
        if (light.size > 0.0) toward += basis(toward) * vec3(light.size * disc, 0.0);
        t_max = FLT_MAX;
    } else {
        toward = light.position - origin;
        float d = length(toward);
        // A point within the light sees it as a disc half as far away as its centre.
        if (light.size > 0.0 && d > 0.0) {
            toward += basis(toward / d) * vec3(min(light.size, 0.5 * d) * disc, 0.0);
        }
    }
    if (dot(toward, face_normal) <= 0.0) return vec3(0.0);
    return transmittance(origin, toward, t_max);
}

#endif
