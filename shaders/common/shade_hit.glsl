// Light that leaves the point where a ray hit the scene's geometry. Needs what shade.glsl, shadow.glsl and baked.glsl need,
// and SHADOWS (some light casts a shadow) and INDIRECT (there is baked light) from the includer.
#ifndef SHADE_HIT_GLSL
#define SHADE_HIT_GLSL
#include "baked.glsl"
#include "shade.glsl"
#include "shadow.glsl"

// As `shade`, with shadows and baked light. `draws` choose a point on each light that has a size.
vec3 shade_hit(Surface s, vec3 emission, Intersection hit, vec3 position, vec3 v, Draws draws) {
    if (SHADOWS + INDIRECT == 0u) return shade(s, emission, position, v);
    vec3 sum;
    if (INDIRECT != 0u) {
        vec3 ambient = baked_light(hit.triangle, hit.uv, sees_back(hit.triangle, -v));
        sum = shade_without_lights_in(ambient, s, emission, v);
    } else {
        sum = shade_without_lights(s, emission, v);
    }
    for (uint i = 0u; i < frame.light_count; ++i) {
        vec3 light = from_light(lights[i], s, position, v);
        if (all(equal(light, vec3(0.0)))) continue;
        if (SHADOWS != 0u) {
            light *= light_share(lights[i], position, s.face_normal, on_disc(draw_2d(draws, DRAW_LIGHT + i)));
        }
        sum += light;
    }
    return sum;
}

#endif
