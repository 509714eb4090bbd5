#version 460
// In: G-buffer. Out: the list of pixels that trace a ray (x | y << 14 | eye << 28) and the arguments of the
// dispatches over it (Stachowiak 2015).
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, std430) readonly buffer Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3, std430) writeonly buffer Rays { uint rays[]; };
// Groups of 64 (x, y, z), then the number of rays.
layout(binding = 4, std430) buffer Arguments { uint arguments[4]; };

shared uint count;
shared uint first;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (gl_LocalInvocationIndex == 0u) count = 0u;
    barrier();
    bool reflects = false;
    if (all(lessThan(id.xy, frame.size)) && texelFetch(depth_image, ivec3(id), 0).x > 0.0) {
        reflects = unpack_roughness(texelFetch(surface_image, ivec3(id), 0)) <= frame.ray_roughness_limit;
    }
    uint place = reflects ? atomicAdd(count, 1u) : 0u;
    barrier();
    if (gl_LocalInvocationIndex == 0u && count > 0u) {
        first = atomicAdd(arguments[3], count);
        atomicMax(arguments[0], (first + count + 63u) / 64u);
    }
    barrier();
    if (reflects) rays[first + place] = id.x | id.y << 14 | id.z << 28;
}
