#version 460
// In: ray list, G-buffer, depth pyramid. Out: for each listed pixel how its reflection ray ended.
// Stochastic screen-space reflections: Stachowiak 2015, the paper's §3. With OTHER_EYE this is the first stage of the paper's
// §4.1: a ray stops where this eye loses it, and is listed for the other eye (trace_other_eye.comp). With LOST_SHARE, rays that
// the views lose are listed for the scene's geometry (trace_geometry.comp).
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform sampler2DArray pyramid;
layout(binding = 6, rgba32ui) writeonly uniform uimage2DArray hit_image;
// Rays that go on in the other eye, in the format of the ray list.
layout(binding = 7, std430) writeonly buffer Retries { uint retries[]; };
layout(binding = 8, std430) buffer RetryArguments { uint retry_arguments[4]; };
// Rays that ask the geometry, in the same format.
layout(binding = 9, std430) writeonly buffer Lost { uint lost[]; };
layout(binding = 10, std430) buffer LostArguments { uint lost_arguments[4]; };
layout(push_constant) uniform Constants { uint sample_index; };

#include "common/append.glsl"
#include "common/ray_list.glsl"
#include "common/screen_ray.glsl"
#include "common/lost.glsl"

layout(constant_id = 1) const uint OTHER_EYE = 0u;
// 0: rays that come back towards the eye are unknown, as in the publication.
layout(constant_id = 2) const uint CAMERA_RAYS = 1u;
// 1: a ray that goes behind matter goes on in the other eye only if the ray and the matter are at least one pixel of disparity
// apart, because only then may the other eye see past the matter; 0: always.
layout(constant_id = 5) const uint BY_DISPARITY = 0u;
// 1: the right eye traces nothing.
layout(constant_id = 3) const uint ONE_EYE = 0u;

// The group counts first, because a device-wide atomic for each ray would cost more than the ray's march.
shared uint tally[TALLY_WORDS];
shared uint retry_count;
shared uint retry_first;
shared uint lost_count;
shared uint lost_first;

// Where a ray goes on after this pass.
const uint DONE = 0u;
const uint TO_OTHER_EYE = 1u;
const uint TO_GEOMETRY = 2u;

// Stores what the views know of a ray. Unless the ray asks the geometry, it is counted under `word` or as skipped.
uint answer(ivec3 texel, bool mirror, Hit hit, uint word) {
    bool asks = false, skipped = false;
    if (LOST_SHARE != 0u) asks = ask_geometry(texel, sample_index, mirror, hit, skipped);
    imageStore(hit_image, texel, pack_hit(hit));
    if (asks) return TO_GEOMETRY;
    atomicAdd(tally[skipped ? TALLY_SKIPPED : word], 1u);
    return DONE;
}

uint trace_listed(ivec3 texel) {
    uint eye = uint(texel.z);
    if (ONE_EYE != 0u && eye == 1u) return DONE;
    ScreenRay r = screen_ray(texel, sample_index);
    Hit hit = Hit(NOTHING, vec2(0.0), eye, r.ray.direction, 0.0, r.ray.pdf, 0.0);
    if (!r.ray.open) {
        atomicAdd(tally[TALLY_BELOW_HORIZON], 1u);
        hit.confidence = r.ray.above ? 1.0 : 0.0;
        if (LOST_SHARE != 0u && !r.mirror) hit.confidence *= float(LOST_SHARE) * (1.0 / 255.0);
        imageStore(hit_image, texel, pack_hit(hit));
        return DONE;
    }
    Segment segment = segment_of(r, eye, 0.0);
    if (CAMERA_RAYS == 0u && segment.w_end < segment.w_start) {
        hit.status = UNKNOWN;
        atomicAdd(tally[TALLY_RAYS], 1u);
        return answer(texel, r.mirror, hit, TALLY_LEFT_VIEW);
    }
    uint stop = STOP_NEVER;
    // Where a ray can go on in the other eye or ask the geometry, it does not go on behind matter without knowing what is there.
    if (OTHER_EYE + LOST_SHARE != 0u) stop = STOP_BEHIND;
    float gap = 0.0;
    if (BY_DISPARITY != 0u) {
        // Raw depth is near / distance. Disparity in pixels is baseline / distance / size of a pixel at distance 1.
        float baseline = distance(eye_position(0u), eye_position(1u));
        gap = pixel_size(eye) * frame.eyes[eye].position_near.w / max(baseline, 1e-12);
    }
    if (OTHER_EYE != 0u) {
        other_eye = 1u - eye;
        other_eye_from = frame.eyes[other_eye].clip_from_render * vec4(r.origin, 1.0);
        other_eye_to = other_eye_from + frame.eyes[other_eye].clip_from_render * vec4(r.ray.direction * frame.ray_length, 0.0);
    }
    March m = march(segment, eye, frame.max_steps, true, stop, LOST_SHARE != 0u ? 0.0 : gap);
    uint word = finish(r, segment, m, eye, m.behind || m.result == MARCH_BEHIND, hit);
    bool behind = m.result == MARCH_BEHIND && m.gap >= gap;
    atomicAdd(tally[TALLY_RAYS], 1u);
    atomicAdd(tally[TALLY_STEPS], m.steps);
    bool left = m.result != MARCH_BEHIND && word == TALLY_LEFT_VIEW && segment.end == END_SIDE;
    // Few of the places where rays leave this eye's view lie within the other eye's view.
    if (left && OTHER_EYE != 0u) left = in_other_view(stored_fraction(hit));
    if (OTHER_EYE != 0u && (behind || left)) {
        imageStore(hit_image, texel, pack_hit(hit));
        return TO_OTHER_EYE;
    }
    return answer(texel, r.mirror, hit, word);
}

void main() {
    uint i = gl_LocalInvocationIndex;
    if (i < TALLY_WORDS) tally[i] = 0u;
    if (i == 0u) {
        retry_count = 0u;
        lost_count = 0u;
    }
    barrier();
    ivec3 texel;
    uint next = DONE;
    if (listed_pixel(texel)) next = trace_listed(texel);
    uint place = 0u;
    if (next == TO_OTHER_EYE) place = atomicAdd(retry_count, 1u);
    if (next == TO_GEOMETRY) place = atomicAdd(lost_count, 1u);
    barrier();
    if (i == 0u) {
        atomicAdd(counters.rays, tally[TALLY_RAYS]);
        atomicAdd(counters.hits, tally[TALLY_HITS]);
        atomicAdd(counters.sky, tally[TALLY_SKY]);
        atomicAdd(counters.left_view, tally[TALLY_LEFT_VIEW]);
        atomicAdd(counters.behind, tally[TALLY_BEHIND]);
        atomicAdd(counters.back_facing, tally[TALLY_BACK_FACING]);
        atomicAdd(counters.budget, tally[TALLY_BUDGET]);
        atomicAdd(counters.below_horizon, tally[TALLY_BELOW_HORIZON]);
        atomicAdd(counters.steps, tally[TALLY_STEPS]);
        if (OTHER_EYE != 0u && retry_count > 0u) MAKE_ROOM(retry_arguments, retry_count, retry_first)
        if (LOST_SHARE != 0u) {
            atomicAdd(counters.skipped, tally[TALLY_SKIPPED]);
            if (lost_count > 0u) MAKE_ROOM(lost_arguments, lost_count, lost_first)
        }
    }
    barrier();
    if (next == TO_OTHER_EYE) retries[retry_first + place] = pack_pixel(texel);
    if (next == TO_GEOMETRY) lost[lost_first + place] = pack_pixel(texel);
}
