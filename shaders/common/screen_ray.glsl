// One reflection ray through the views: where it starts, and what the end of its march means. Needs `frame`, `surface_image`
// and `pyramid` from the includer.
#ifndef SCREEN_RAY_GLSL
#define SCREEN_RAY_GLSL
#include "brdf.glsl"
#include "camera.glsl"
#include "hit.glsl"

// The end of a ray may be rounded into a cell beyond the image, hence the `min`.
vec2 load_range(ivec2 cell, int level, uint eye) {
    return texelFetch(pyramid, ivec3(min(cell, ivec2(frame.size) - 1 >> level), eye), level).xy;
}

#include "march.glsl"
#include "random.glsl"
#include "reflect.glsl"

// 1: a hit fades by the eye's view whose border is farther from it (paper §4.2); 0: by the view of the eye that found it.
layout(constant_id = 0) const uint STEREO_FADE = 0u;

// The ends of the ray in the other eye's clip space. An includer that calls `in_other_view` sets them.
vec4 other_eye_from, other_eye_to;
uint other_eye;

// Whether the ray's world fraction s lies inside the other eye's view.
bool in_other_view(float s) {
    vec4 c = mix(other_eye_from, other_eye_to, s);
    return c.w >= frame.eyes[other_eye].position_near.w && all(lessThanEqual(abs(c.xy), vec2(c.w)));
}

struct ScreenRay {
    vec3 origin;
    ReflectionRay ray;
    bool mirror;
};

ScreenRay screen_ray(ivec3 texel, uint sample_index) {
    uint eye = uint(texel.z);
    float depth = load_range(texel.xy, 0, eye).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    vec2 u = sample_2d(combine(frame.seed, frame.frame), frame.eyes[eye].stream.x, uvec2(texel.xy), sample_index);
    return ScreenRay(ray_origin(eye, position, s.face_normal, depth), reflection_ray(s, v, u), is_mirror(s));
}

// The part of the ray, from world fraction `s` on, that lies in an eye's view.
Segment segment_of(ScreenRay r, uint eye, float s) {
    mat4 clip = frame.eyes[eye].clip_from_render;
    vec4 a = clip * vec4(r.origin, 1.0);
    vec4 b = a + clip * vec4(r.ray.direction * frame.ray_length, 0.0);
    return clip_segment(a, b, s, frame.eyes[eye].position_near.w, vec2(frame.size));
}

// The world fraction where an eye lost a ray, at the precision that a packed hit keeps: rounded towards the origin by up to
// 1/4096.
float stored_fraction(Hit hit) { return clamp(unpack_hit(pack_hit(hit)).distance / frame.ray_length, 0.0, 1.0); }

// 1 inside the view, falling to 0 at its border, because what lies beyond is not known.
float edge_fade(vec2 uv) {
    if (frame.edge_fade <= 0.0) return 1.0;
    vec2 f = smoothstep(vec2(0.0), vec2(1.0), min(uv, 1.0 - uv) / frame.edge_fade);
    return f.x * f.y;
}

float fade_in(uint eye, vec3 position) {
    vec4 clip = frame.eyes[eye].clip_from_render * vec4(position, 1.0);
    return clip.w > 0.0 ? edge_fade(vec2(clip.x, -clip.y) / clip.w * 0.5 + 0.5) : 0.0;
}

float hit_confidence(ScreenRay r, Hit hit) {
    if (frame.edge_fade <= 0.0) return 1.0;
    vec3 position = r.origin + r.ray.direction * hit.distance;
    float own = fade_in(hit.eye, position);
    return STEREO_FADE != 0u ? max(own, fade_in(1u - hit.eye, position)) : own;
}

// Words of a group's tally, which counts how its rays end, in the order of CountersData from `rays` on.
const uint TALLY_RAYS = 0u, TALLY_HITS = 1u, TALLY_SKY = 2u, TALLY_LEFT_VIEW = 3u, TALLY_BEHIND = 4u;
const uint TALLY_BACK_FACING = 5u, TALLY_BUDGET = 6u, TALLY_BELOW_HORIZON = 7u, TALLY_STEPS = 8u, TALLY_SKIPPED = 9u;
const uint TALLY_WORDS = 10u;

// Fills in the hit of a ray that met the matter of a pixel at the ray's world fraction `s`. Returns the word of the tally that
// counts it.
uint found(ScreenRay r, ivec3 at, float s, inout Hit hit) {
    hit.status = UNKNOWN;
    hit.confidence = 0.0;
    hit.eye = uint(at.z);
    hit.distance = s * frame.ray_length;
    // The pixel's centre. A point just inside the pixel's border could be rounded into the neighbour in 16 bits.
    hit.uv = (vec2(at.xy) + 0.5) / vec2(frame.size);
    vec3 n = unpack_direction(texelFetch(surface_image, at, 0).y);
    if (dot(n, r.ray.direction) >= 0.0) return TALLY_BACK_FACING;
    hit.status = HIT;
    hit.confidence = hit_confidence(r, hit);
    return TALLY_HITS;
}

// Fills in the hit from the end of the march. Returns the word of the tally that counts it. `behind`: the ray went behind
// matter that neither eye could look past.
uint finish(ScreenRay r, Segment segment, March m, uint eye, bool behind, inout Hit hit) {
    float s = world_fraction(segment, m.t);
    if (m.result == MARCH_HIT) {
        vec2 pixel = segment.start.xy + segment.delta.xy * m.t;
        return found(r, ivec3(clamp(ivec2(pixel), ivec2(0), ivec2(frame.size) - 1), eye), s, hit);
    }
    hit.status = UNKNOWN;
    hit.confidence = 0.0;
    hit.eye = eye;
    hit.distance = s * frame.ray_length;
    if (m.result == MARCH_BUDGET) return TALLY_BUDGET;
    if (segment.end != END_FAR) return TALLY_LEFT_VIEW;
    if (behind) return TALLY_BEHIND;
    hit.status = SKY;
    hit.confidence = 1.0;
    return TALLY_SKY;
}

#endif
