#version 460
// In: visibility and depth, normals. Out: visibility filtered along one axis (x, then y) by the cross-bilateral filter
// (Eisemann & Durand 2004), with the weight of its taps; with LISTED at the listed pixels alone.
// A tap's weight falls with its distance in pixels, with a standard deviation of 3 (seed 001, § "Experiments"), and with its
// position's distance from the pixel's plane.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

#ifdef LISTED
layout(local_size_x = 64) in;
#else
layout(local_size_x = 8, local_size_y = 8) in;
#endif
// 0: the first pass, along x; 1: the second pass, along y.
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

// Pixels: twice the standard deviation.
const int REACH = 6;
const float SPREAD = 3.0;
// Σ exp(−k²/(2·3²)) over −6 ≤ k ≤ 6: the largest possible sum of the taps' weights.
const float MOST_WEIGHT = 7.29805;
// Standard deviation of the distances from the plane, in widths of a pixel at the pixel's distance.
const float PLANE_SPREAD = 1.0;

void filter_pixel(ivec3 texel) {
    uvec2 own = texelFetch(from_image, texel, 0).xy;
    float depth = uintBitsToFloat(own.y);
    if (depth == 0.0) {
        if (SECOND != 0u) imageStore(visibility_image, texel, vec4(1.0));
        else imageStore(to_image, texel, uvec4(own, 0u, 0u));
        return;
    }
    // Not a conditional expression: Mesa 22.3 gives (0, 0) when a specialisation constant selects between constant vectors.
    ivec2 axis = ivec2(1, 0);
    if (SECOND != 0u) axis = ivec2(0, 1);
    EyeRays e = eye_rays(uint(texel.z));
    vec3 normal = unpack_direction(texelFetch(surface_image, texel, 0).y);
    // A position's height over the eye along the normal: a linear function of the pixel, times the distance along the view.
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
    // All invocations of a group belong to one eye, so that a software device loads the eye's constants once for all lanes.
    if (all(lessThan(id.xy, frame.size))) filter_pixel(ivec3(id.xy, gl_WorkGroupID.z));
#endif
}
