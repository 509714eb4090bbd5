#version 460
// In: the map of pairs, raw visibility where it was estimated. Out: raw visibility of the pixels that copy their pair
// (seed 001, § "Stereo-aware obscurance estimation": reprojection with a check that the pair leads back).
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/ao.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray pair_image;
// Read and written in one pass without a race: a pixel that copies is never copied itself.
layout(binding = 2, rg32ui) uniform uimage2DArray raw_image;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    uvec2 word = texelFetch(pair_image, texel, 0).xy;
    if ((word.y & COPIES) == 0u) return;
    imageStore(raw_image, texel, uvec4(imageLoad(raw_image, pair_of(word, texel.z)).x, word.x, 0u, 0u));
}
