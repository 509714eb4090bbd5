#version 460
// In: ray list, G-buffer, depth pyramid. Out: for each listed pixel how its reflection ray ended.
// Stochastic screen-space reflections: Stachowiak 2015, the paper's §3. With OTHER_EYE the first stage of the paper's
// §4.1: a ray stops where this eye sees no more of it, and is listed for the other eye (trace_other_eye.comp).
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
// Rays for the other eye: as the ray list.
layout(binding = 7, std430) writeonly buffer Retries { uint retries[]; };
layout(binding = 8, std430) buffer RetryArguments { uint retry_arguments[4]; };
layout(push_constant) uniform Constants { uint sample_index; };

#include "common/ray_list.glsl"
#include "common/screen_ray.glsl"

layout(constant_id = 1) const uint OTHER_EYE = 0u;
// 0: rays that come back towards the eye are unknown, as in the publication.
layout(constant_id = 2) const uint CAMERA_RAYS = 1u;
// 1: the right eye traces nothing.
layout(constant_id = 3) const uint ONE_EYE = 0u;

// Counted in the group first: a device-wide atomic a ray would cost more than its march.
shared uint tally[TALLY_WORDS];
shared uint retry_count;
shared uint retry_first;

// Whether the ray goes to the other eye.
bool trace_listed(ivec3 texel) {
    uint eye = uint(texel.z);
    if (ONE_EYE != 0u && eye == 1u) return false;
    ScreenRay r = screen_ray(texel, sample_index);
    Hit hit = Hit(NOTHING, vec2(0.0), eye, r.ray.direction, 0.0, r.ray.pdf, 0.0);
    if (!r.ray.open) {
        atomicAdd(tally[TALLY_BELOW_HORIZON], 1u);
        hit.confidence = r.ray.above ? 1.0 : 0.0;
        imageStore(hit_image, texel, pack_hit(hit));
        return false;
    }
    Segment segment = segment_of(r, eye, 0.0);
    if (CAMERA_RAYS == 0u && segment.w_end < segment.w_start) {
        hit.status = UNKNOWN;
        imageStore(hit_image, texel, pack_hit(hit));
        atomicAdd(tally[TALLY_RAYS], 1u);
        atomicAdd(tally[TALLY_LEFT_VIEW], 1u);
        return false;
    }
    uint stop = STOP_NEVER;
    if (OTHER_EYE != 0u) stop = STOP_BEHIND;
    March m = march(segment, eye, frame.max_steps, true, stop);
    uint word = finish(r, segment, m, eye, m.behind, hit);
    imageStore(hit_image, texel, pack_hit(hit));
    atomicAdd(tally[TALLY_RAYS], 1u);
    atomicAdd(tally[TALLY_STEPS], m.steps);
    bool retry = OTHER_EYE != 0u && (m.result == MARCH_BEHIND || word == TALLY_LEFT_VIEW && segment.end == END_SIDE);
    if (!retry) atomicAdd(tally[word], 1u);
    return retry;
}

void main() {
    uint i = gl_LocalInvocationIndex;
    if (i < TALLY_WORDS) tally[i] = 0u;
    if (i == 0u) retry_count = 0u;
    barrier();
    ivec3 texel;
    bool retry = false;
    if (listed_pixel(texel)) retry = trace_listed(texel);
    uint place = retry ? atomicAdd(retry_count, 1u) : 0u;
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
        if (OTHER_EYE != 0u && retry_count > 0u) {
            retry_first = atomicAdd(retry_arguments[3], retry_count);
            uint groups = (retry_first + retry_count + 63u) / 64u;
            atomicMax(retry_arguments[0], min(groups, ROW_OF_GROUPS));
            atomicMax(retry_arguments[1], (groups + ROW_OF_GROUPS - 1u) / ROW_OF_GROUPS);
        }
    }
    barrier();
    if (retry) retries[retry_first + place] = pack_pixel(texel);
}
