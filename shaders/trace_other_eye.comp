#version 460
// In: the rays that left their own eye's view or went behind matter there, G-buffer, depth pyramid. Out: their hits.
// The second stage of the paper's §4.1 (both cases of its Fig. 3): the ray goes on in the other eye's view from the world
// fraction where its own eye lost it. If that eye loses it too, the ray goes on behind the matter in its own eye's view, as the
// baseline's rays do (§5.4). To go on alternating between the eyes (see trace_one_loop.comp) would answer one ray in a hundred
// more and cost as much again.
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
layout(binding = 6, rgba32ui) uniform uimage2DArray hit_image;
// Rays that neither eye answers and that ask the geometry, in the format of the ray list.
layout(binding = 7, std430) writeonly buffer Lost { uint lost[]; };
layout(binding = 8, std430) buffer LostArguments { uint lost_arguments[4]; };
layout(push_constant) uniform Constants { uint sample_index; };

#include "common/append.glsl"
#include "common/ray_list.glsl"
#include "common/screen_ray.glsl"
#include "common/lost.glsl"

shared uint tally[TALLY_WORDS];
shared uint lost_count;
shared uint lost_first;

// Whether the ray must ask the geometry.
bool trace_listed(ivec3 texel) {
    uint own = uint(texel.z), other = 1u - own;
    ScreenRay r = screen_ray(texel, sample_index);
    Hit hit = unpack_hit(imageLoad(hit_image, texel));
    float s = stored_fraction(hit);
    hit.direction = r.ray.direction;
    Segment first = segment_of(r, own, 0.0);
    bool left_own = first.end != END_FAR && s >= first.s_end * (1.0 - 1.0 / 2048.0);

    uint word = left_own ? TALLY_LEFT_VIEW : TALLY_BEHIND;
    uint steps = 0u;
    Segment segment = segment_of(r, other, s);
    bool seen = segment.inside, lost = !seen;
    if (seen) {
        March m = march(segment, other, frame.max_steps, false, STOP_BEHIND, 0.0);
        steps += m.steps;
        lost = m.result == MARCH_BEHIND;
        if (lost) s = world_fraction(segment, m.t);
        else word = finish(r, segment, m, other, false, hit);
        // The ray left the other eye's view or ran out of steps there, but is still in its own eye's view: it goes on there.
        if ((word == TALLY_LEFT_VIEW || word == TALLY_BUDGET) && !left_own) {
            lost = true;
            s = world_fraction(segment, m.t);
        }
    }
    // Where a ray can ask the geometry, it does not go on behind matter without knowing what is there.
    if (LOST_SHARE != 0u && lost) {
        word = left_own ? TALLY_LEFT_VIEW : TALLY_BEHIND;
        hit.status = UNKNOWN;
    } else if (lost && !left_own) {
        segment = segment_of(r, own, min(s, first.s_end));
        March m = march(segment, own, frame.max_steps, false, STOP_NEVER, 0.0);
        steps += m.steps;
        word = finish(r, segment, m, own, m.behind || !seen, hit);
    }
    atomicAdd(tally[TALLY_STEPS], steps);
    bool asks = false, skipped = false;
    if (LOST_SHARE != 0u) asks = ask_geometry(texel, sample_index, r.mirror, hit, skipped);
    if (!asks) atomicAdd(tally[skipped ? TALLY_SKIPPED : word], 1u);
    imageStore(hit_image, texel, pack_hit(hit));
    return asks;
}

void main() {
    uint i = gl_LocalInvocationIndex;
    if (i < TALLY_WORDS) tally[i] = 0u;
    if (i == 0u) lost_count = 0u;
    barrier();
    ivec3 texel;
    bool asks = false;
    if (listed_pixel(texel)) asks = trace_listed(texel);
    uint place = 0u;
    if (asks) place = atomicAdd(lost_count, 1u);
    barrier();
    if (i == 0u) {
        atomicAdd(counters.hits, tally[TALLY_HITS]);
        atomicAdd(counters.sky, tally[TALLY_SKY]);
        atomicAdd(counters.left_view, tally[TALLY_LEFT_VIEW]);
        atomicAdd(counters.behind, tally[TALLY_BEHIND]);
        atomicAdd(counters.back_facing, tally[TALLY_BACK_FACING]);
        atomicAdd(counters.budget, tally[TALLY_BUDGET]);
        atomicAdd(counters.steps, tally[TALLY_STEPS]);
        if (LOST_SHARE != 0u) {
            atomicAdd(counters.skipped, tally[TALLY_SKIPPED]);
            if (lost_count > 0u) MAKE_ROOM(lost_arguments, lost_count, lost_first)
        }
    }
    barrier();
    if (asks) lost[lost_first + place] = pack_pixel(texel);
}
