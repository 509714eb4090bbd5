#version 460
// In: G-buffer, and with STEREO the map of pairs. Out: raw visibility and depth of each pixel; with LISTED of the listed
// pixels alone.
// Without LISTED, pixels that copy their pair are left to ao_reproject.comp. With LISTED, a listed pixel also writes the value
// of the pixel that copies it; a copying pixel whose pair is not listed is estimated itself, at its pair's pixel.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

#ifdef LISTED
layout(local_size_x = 64) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
// 1: every sample is looked up in both views.
layout(constant_id = 0) const uint STEREO = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3) uniform usampler2DArray pair_image;
layout(binding = 4, rg32ui) writeonly uniform uimage2DArray raw_image;
#ifdef LISTED
layout(binding = 5, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 6, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 7) uniform sampler2DArray visibility_image;
#endif
layout(push_constant) uniform Constants {
    float radius;       // of the disk, metres
    float threshold;    // see ao_adaptive.comp
};

#include "common/ao_estimate.glsl"
#ifdef LISTED
#include "common/ray_list.glsl"

// Whether ao_adaptive.comp has listed the first pixel for its difference from the second.
bool is_listed(ivec3 texel, ivec3 pair) {
    float own = texelFetch(visibility_image, texel, 0).x;
    return differs_visibly(own, texelFetch(visibility_image, pair, 0).x, threshold);
}

void estimate(ivec3 texel) {
    uvec2 word = texelFetch(pair_image, texel, 0).xy;
    ivec3 pair = pair_of(word, texel.z);
    uvec2 of_pair = (word.y & PAIRED) != 0u ? texelFetch(pair_image, pair, 0).xy : uvec2(0u);
    bool mutual = (of_pair.y & PAIRED) != 0u && pair_of(of_pair, pair.z) == texel;
    bool copies = (word.y & COPIES) != 0u;
    if (copies && mutual && is_listed(pair, texel)) return;
    float open = visibility(copies ? pair : texel, uintBitsToFloat(copies ? of_pair.x : word.x));
    imageStore(raw_image, texel, uvec4(pack_visibility(open, 1.0, uintBitsToFloat(word.x)), 0u, 0u));
    if (mutual && (of_pair.y & COPIES) != 0u) {
        imageStore(raw_image, pair, uvec4(pack_visibility(open, 1.0, uintBitsToFloat(of_pair.x)), 0u, 0u));
    }
}
#endif

void main() {
#ifdef LISTED
    ivec3 texel;
    if (listed_pixel(texel)) estimate(texel);
#else
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    // All invocations of a group belong to one eye, so that a software device loads the eye's constants once for all lanes.
    ivec3 texel = ivec3(id.xy, gl_WorkGroupID.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    if (STEREO != 0u) {
        if ((texelFetch(pair_image, texel, 0).y & COPIES) != 0u) return;
    }
    float open = depth > 0.0 ? visibility(texel, depth) : 1.0;
    imageStore(raw_image, texel, uvec4(pack_visibility(open, 1.0, depth), 0u, 0u));
#endif
}
