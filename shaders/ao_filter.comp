#version 460
// In: visibility and depth, normals. Out: visibility filtered along one axis (x, then y) by the cross-bilateral filter
// (Eisemann & Durand 2004), with how much its taps weigh; with LISTED at the listed pixels alone.
// A tap weighs by its distance in pixels, spread 3 (seed 001, § "Experiments"), and by how far its place in the world lies
// off the pixel's plane.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

#ifdef LISTED
layout(local_size_x = 64) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
// 0: along x, for the second pass; 1: along y.
layout(constant_id = 0) const uint SECOND = 0u;
// 1: the second pass keeps the weights, for the other eye.
layout(constant_id = 1) const uint KEEP_WEIGHTS = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform usampler2DArray from_image;
layout(binding = 3, rg32ui) writeonly uniform uimage2DArray to_image;
layout(binding = 4, r32f) writeonly uniform image2DArray visibility_image;
#ifdef LISTED
layout(binding = 5, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 6, std430) readonly buffer Arguments { uint arguments[4]; };
#endif

#include "common/ao.glsl"
#include "common/camera.glsl"
#include "common/math.glsl"
#ifdef LISTED
#include "common/ray_list.glsl"
#endif

// Pixels; twice the spread.
const int REACH = 6;
const float SPREAD = 3.0;
// Σ exp(−k²/(2·3²)) over −6 ≤ k ≤ 6: the most that the taps can weigh.
const float MOST_WEIGHT = 7.29805;
// Spread of the distances from the plane: so many pixels' width at the pixel's distance.
const float PLANE_SPREAD = 1.0;

void filter_pixel(ivec3 texel) {
    uvec2 own = texelFetch(from_image, texel, 0).xy;
    float depth = uintBitsToFloat(own.y);
    if (depth == 0.0) {
        if (SECOND != 0u) imageStore(visibility_image, texel, vec4(1.0));
        else imageStore(to_image, texel, uvec4(own, 0u, 0u));
        return;
    }
    // Written out: Mesa 22.3 gives (0, 0) for a choice between constant vectors by a specialisation constant.
    ivec2 axis = ivec2(1, 0);
    if (SECOND != 0u) axis = ivec2(0, 1);
    EyeRays e = eye_rays(uint(texel.z));
    vec3 normal = unpack_direction(texelFetch(surface_image, texel, 0).y);
    // Height of a place over the eye along the normal: linear in the pixel, times its distance along the view.
    vec2 center = vec2(texel.xy) + 0.5;
    float height = dot(normal, e.first + center.x * e.across + center.y * e.down);
    float rise = dot(normal, SECOND != 0u ? e.down : e.across);
    float distance = e.near / depth, own_height = height * distance;
    float scale = 1.0 / (PLANE_SPREAD * pixel_size(uint(texel.z)) * distance);
    float sum = 0.0, weights = 0.0, worth = 0.0;
    for (int k = -REACH; k <= REACH; ++k) {
        ivec2 at = texel.xy + k * axis;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        uvec2 word = texelFetch(from_image, ivec3(at, texel.z), 0).xy;
        float tap_depth = uintBitsToFloat(word.y);
        if (tap_depth == 0.0) continue;
        vec2 tap = unpack_visibility(word.x);
        float off = ((height + float(k) * rise) * (e.near / tap_depth) - own_height) * scale;
        float weight = exp(-0.5 * (float(k * k) * (1.0 / (SPREAD * SPREAD)) + off * off));
        sum += weight * tap.x;
        weights += weight;
        worth += weight * tap.y;
    }
    // The pixel itself weighs 1.
    float mean = sum / weights;
    uvec2 filtered = pack_visibility(mean, worth * (1.0 / MOST_WEIGHT), depth);
    if (SECOND == 0u) {
        imageStore(to_image, texel, uvec4(filtered, 0u, 0u));
    } else {
        imageStore(visibility_image, texel, vec4(mean));
        if (KEEP_WEIGHTS != 0u) imageStore(to_image, texel, uvec4(filtered, 0u, 0u));
    }
}

void main() {
#ifdef LISTED
    ivec3 texel;
    if (listed_pixel(texel)) filter_pixel(texel);
#else
    uvec3 id = gl_GlobalInvocationID;
    // A group has one eye, so that a software device loads what belongs to it once for all lanes.
    if (all(lessThan(id.xy, frame.size))) filter_pixel(ivec3(id.xy, gl_WorkGroupID.z));
#endif
}
