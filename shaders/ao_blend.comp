#version 460
// In: each eye's filtered visibility with the weight of its taps, the map of pairs. Out: visibility of the pixels that have a
// pair, or with LISTED of the listed ones: both eyes' values blended by their weights (seed 001, equation 1: Shi et al. 2022).
// The pair's neighbourhood was already filtered for the pair itself, so nothing is filtered twice.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/ao.glsl"

#ifdef LISTED
layout(local_size_x = 64) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray pair_image;
layout(binding = 2) uniform usampler2DArray filtered_image;
layout(binding = 3, r32f) writeonly uniform image2DArray visibility_image;
#ifdef LISTED
layout(binding = 4, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 5, std430) readonly buffer Arguments { uint arguments[4]; };
#include "common/ray_list.glsl"
#endif

void blend(ivec3 texel) {
    uvec2 word = texelFetch(pair_image, texel, 0).xy;
    if ((word.y & PAIRED) == 0u) return;
    vec2 own = unpack_visibility(texelFetch(filtered_image, texel, 0).x);
    vec2 other = unpack_visibility(texelFetch(filtered_image, pair_of(word, texel.z), 0).x);
    float share = smoothstep(0.45, 0.50, own.y / max(own.y + other.y, 1e-6));
    // With a share of 1 the image already holds this eye's own value.
    if (share < 1.0) imageStore(visibility_image, texel, vec4(mix(other.x, own.x, share)));
}

void main() {
#ifdef LISTED
    ivec3 texel;
    if (listed_pixel(texel)) blend(texel);
#else
    uvec3 id = gl_GlobalInvocationID;
    if (all(lessThan(id.xy, frame.size))) blend(ivec3(id));
#endif
}
