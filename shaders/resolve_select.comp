#version 460
// In: ray list, and which pixels resolve.comp has finished. Out: the list of the others, in which the eyes may differ visibly,
// for reproject.comp: the adaptive map of seed 001 (Wu, adaptive stereo ambient occlusion, §4).
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 1, std430) readonly buffer Arguments { uint arguments[4]; };
// w: 1 where the pixel is finished.
layout(binding = 2) uniform sampler2DArray standing_image;
layout(binding = 3, std430) writeonly buffer Visible { uint visible[]; };
layout(binding = 4, std430) buffer VisibleArguments { uint visible_arguments[4]; };

#include "common/append.glsl"
#include "common/ray_list.glsl"

shared uint count;
shared uint first;

void main() {
    if (gl_LocalInvocationIndex == 0u) count = 0u;
    barrier();
    ivec3 texel;
    bool goes_on = listed_pixel(texel);
    if (goes_on) goes_on = texelFetch(standing_image, texel, 0).w == 0.0;
    uint place = goes_on ? atomicAdd(count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && count > 0u) MAKE_ROOM(visible_arguments, count, first)
    barrier();
    if (goes_on) visible[first + place] = pack_pixel(texel);
}
