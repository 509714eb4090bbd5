// Light that leaves what a ray of the geometry hit. Needs what shade.glsl and shadow.glsl need, and SHADOWS (some light
// casts a shadow) from the includer.
#ifndef SHADE_HIT_GLSL
#define SHADE_HIT_GLSL
#include "shade.glsl"
#include "shadow.glsl"

// As `shade` has it, in the shadows of the lights; `draws` choose the points of the lights that have a size.
vec3 shade_hit(Surface s, vec3 emission, vec3 position, vec3 v, Draws draws) {
    if (SHADOWS == 0u) return shade(s, emission, position, v);
    vec3 sum = shade_without_lights(s, emission, v);
    for (uint i = 0u; i < frame.light_count; ++i) {
        vec3 light = from_light(lights[i], s, position, v);
        if (all(equal(light, vec3(0.0)))) continue;
        sum += light * light_share(lights[i], position, s.face_normal, on_disc(draw_2d(draws, DRAW_LIGHT + i)));
    }
    return sum;
}

#endif
