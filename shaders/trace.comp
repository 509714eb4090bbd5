#version 460
// In: ray list, G-buffer, depth pyramid. Out: for each listed pixel how its reflection ray ended.
// Stochastic screen-space reflections: Stachowiak 2015, the paper's §3 (the baseline).
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, std430) readonly buffer Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform sampler2DArray pyramid;
layout(binding = 6, rgba32ui) writeonly uniform uimage2DArray hit_image;
layout(push_constant) uniform Constants { uint sample_index; };

vec2 load_range(ivec2 cell, int level, uint eye) { return texelFetch(pyramid, ivec3(cell, eye), level).xy; }

#include "common/brdf.glsl"
#include "common/camera.glsl"
#include "common/hit.glsl"
#include "common/march.glsl"
#include "common/random.glsl"
#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/surface.glsl"

// 1 inside, 0 at the view's border: what lies beyond is not known.
float edge_fade(vec2 uv) {
    vec2 d = min(uv, 1.0 - uv) / max(frame.edge_fade, 1e-6);
    vec2 f = smoothstep(vec2(0.0), vec2(1.0), d);
    return frame.edge_fade > 0.0 ? f.x * f.y : 1.0;
}

// Counted in the group first: a device-wide atomic a ray would cost more than its march.
shared uint tally[10];

void trace_listed();

void main() {
    uint i = gl_LocalInvocationIndex;
    if (i < 10u) tally[i] = 0u;
    barrier();
    trace_listed();
    barrier();
    if (i == 0u) {
        atomicAdd(counters.rays, tally[0]);
        atomicAdd(counters.hits, tally[1]);
        atomicAdd(counters.sky, tally[2]);
        atomicAdd(counters.left_view, tally[3]);
        atomicAdd(counters.behind, tally[4]);
        atomicAdd(counters.back_facing, tally[5]);
        atomicAdd(counters.budget, tally[6]);
        atomicAdd(counters.below_horizon, tally[7]);
        atomicAdd(counters.steps, tally[8]);
    }
}

void trace_listed() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uint eye = uint(texel.z);
    float depth = load_range(texel.xy, 0, eye).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    Hit hit = Hit(NOTHING, vec2(0.0), eye, vec3(0.0, 0.0, 1.0), 0.0, 1.0, 0.0);

    vec2 u = sample_2d(combine(frame.seed, frame.frame), frame.eyes[eye].stream.x, uvec2(texel.xy), sample_index);
    ReflectionRay ray = reflection_ray(s, v, u);
    if (!ray.above) {
        atomicAdd(tally[7], 1u);
        imageStore(hit_image, texel, pack_hit(hit));
        return;
    }
    hit.direction = ray.direction;
    hit.pdf = ray.pdf;

    vec3 origin = ray_origin(eye, position, s.face_normal, depth);
    mat4 clip = frame.eyes[eye].clip_from_render;
    float near = frame.eyes[eye].position_near.w;
    vec4 a = clip * vec4(origin, 1.0);
    Segment segment = clip_segment(a, a + clip * vec4(ray.direction * frame.ray_length, 0.0), near, vec2(frame.size));
    March m = march(segment, eye, frame.max_steps);

    hit.status = UNKNOWN;
    hit.distance = world_fraction(segment, m.t) * frame.ray_length;
    if (m.result == MARCH_HIT) {
        vec2 pixel = segment.start.xy + segment.delta.xy * m.t;
        hit.uv = clamp(pixel / vec2(frame.size), vec2(0.0), vec2(1.0));
        ivec3 at = ivec3(min(ivec2(pixel), ivec2(frame.size) - 1), eye);
        vec3 n = unpack_direction(texelFetch(surface_image, at, 0).y);
        if (dot(n, ray.direction) < 0.0) {
            hit.status = HIT;
            hit.confidence = edge_fade(hit.uv);
            atomicAdd(tally[1], 1u);
        } else {
            atomicAdd(tally[5], 1u);
        }
    } else if (m.result == MARCH_BUDGET) {
        atomicAdd(tally[6], 1u);
    } else if (segment.end != END_FAR) {
        atomicAdd(tally[3], 1u);
    } else if (m.behind) {
        atomicAdd(tally[4], 1u);
    } else {
        hit.status = SKY;
        hit.confidence = 1.0;
        atomicAdd(tally[2], 1u);
    }
    atomicAdd(tally[0], 1u);
    atomicAdd(tally[8], m.steps);
    imageStore(hit_image, texel, pack_hit(hit));
}
