#version 460
// In: G-buffer, and for both views the map of pairs. Out: raw visibility and depth of each pixel; with LISTED of the listed
// pixels alone. A pixel that copies its pair is left to ao_reproject.comp; a listed one is estimated where its pair is.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

#ifdef LISTED
layout(local_size_x = 64) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
// 1: in both views.
layout(constant_id = 0) const uint STEREO = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3) uniform usampler2DArray pair_image;
layout(binding = 4, rg32ui) writeonly uniform uimage2DArray raw_image;
#ifdef LISTED
layout(binding = 5, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 6, std430) readonly buffer Arguments { uint arguments[4]; };
#endif
// Of the disk, metres.
layout(push_constant) uniform Constants { float radius; };

#include "common/ao_estimate.glsl"
#ifdef LISTED
#include "common/ray_list.glsl"
#endif

void main() {
#ifdef LISTED
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uvec2 word = texelFetch(pair_image, texel, 0).xy;
    bool copies = (word.y & COPIES) != 0u;
    ivec3 at = copies ? pair_of(word, texel.z) : texel;
    float depth = uintBitsToFloat(word.x);
    float depth_there = copies ? uintBitsToFloat(texelFetch(pair_image, at, 0).x) : depth;
    imageStore(raw_image, texel, uvec4(pack_visibility(visibility(at, depth_there), 1.0, depth), 0u, 0u));
#else
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    float depth = texelFetch(depth_image, texel, 0).x;
    if (STEREO != 0u) {
        if ((texelFetch(pair_image, texel, 0).y & COPIES) != 0u) return;
    }
    float open = depth > 0.0 ? visibility(texel, depth) : 1.0;
    imageStore(raw_image, texel, uvec4(pack_visibility(open, 1.0, depth), 0u, 0u));
#endif
}
