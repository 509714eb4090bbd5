#version 460
// In: G-buffer. Out: the list of pixels that trace a ray (x | y << 14 | eye << 28), the arguments of the indirect dispatches
// over it (Stachowiak 2015), and the guide: all that the resolve needs to know of a neighbour, in one texel.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// 1: a later pass reads the guide.
layout(constant_id = 0) const uint WANT_GUIDE = 1u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3, std430) writeonly buffer Rays { uint rays[]; };
// The number of groups of 64 in x, y and z, then the number of rays.
layout(binding = 4, std430) buffer Arguments { uint arguments[4]; };

layout(binding = 5) uniform usampler2DArray instance_image;
layout(binding = 6, rgba32ui) writeonly uniform uimage2DArray guide_image;

#include "common/append.glsl"
#include "common/camera.glsl"
#include "common/guide.glsl"

shared uint count;
shared uint first;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (gl_LocalInvocationIndex == 0u) count = 0u;
    barrier();
    bool reflects = false;
    if (all(lessThan(id.xy, frame.size))) {
        float depth = texelFetch(depth_image, ivec3(id), 0).x;
        uvec4 packed = texelFetch(surface_image, ivec3(id), 0);
        reflects = depth > 0.0 && is_shown(ivec2(id.xy)) && unpack_roughness(packed) <= frame.ray_roughness_limit;
        if (WANT_GUIDE != 0u) {
            uint instance = reflects ? texelFetch(instance_image, ivec3(id), 0).x : 0u;
            imageStore(guide_image, ivec3(id), pack_guide(Guide(packed.x, depth, instance, unpack_roughness(packed))));
        }
    }
    uint place = reflects ? atomicAdd(count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && count > 0u) MAKE_ROOM(arguments, count, first)
    barrier();
    if (reflects) rays[first + place] = id.x | id.y << 14 | id.z << 28;
}
