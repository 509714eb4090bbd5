#version 460
// In: filtered visibility of both eyes, the map of pairs. Out: the list of the pixels that differ visibly from their pair,
// with the arguments of the indirect dispatches over it: the adaptive map of seed 001 (its equation 2, after Weber's law).
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray pair_image;
layout(binding = 2) uniform sampler2DArray visibility_image;
layout(binding = 3, std430) writeonly buffer Rays { uint rays[]; };
layout(binding = 4, std430) buffer Arguments { uint arguments[4]; };
// The smallest visible difference between the eyes, relative to the pixel's own value.
layout(push_constant) uniform Constants { float threshold; };

#include "common/ao.glsl"
#include "common/append.glsl"

shared uint count;
shared uint first;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (gl_LocalInvocationIndex == 0u) count = 0u;
    barrier();
    bool differs = false;
    if (all(lessThan(id.xy, frame.size))) {
        ivec3 texel = ivec3(id);
        uvec2 word = texelFetch(pair_image, texel, 0).xy;
        if ((word.y & PAIRED) != 0u) {
            float own = texelFetch(visibility_image, texel, 0).x;
            differs = differs_visibly(own, texelFetch(visibility_image, pair_of(word, texel.z), 0).x, threshold);
        }
    }
    uint place = differs ? atomicAdd(count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && count > 0u) MAKE_ROOM(arguments, count, first)
    barrier();
    if (differs) rays[first + place] = id.x | id.y << 14 | id.z << 28;
}
