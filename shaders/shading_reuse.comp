#version 460
// In: G-buffer, the outgoing light of the punctual lights at the left eye's pixels and its diffuse part, which instances share
// their shading; with SHADOWS what is known of the pixels' lights. Out: the same light at those pixels of the right eye whose
// surface the left eye sees too; the list of its other pixels, with the arguments of the indirect dispatches over it.
// Reverse reprojection, its depth test against the nearest of three samples, and the mask: Zhang & Green, Stereo Shading
// Reprojection, 2017. The demodulation by the albedo and the bound of the error are ours.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// 1: lights cast shadows.
layout(constant_id = 0) const uint SHADOWS = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3) uniform usampler2DArray instance_image;
layout(binding = 4) uniform sampler2D diffuse_image;
// One word for each instance: 1 if its material lets the eyes share its shading.
layout(binding = 5, std430) readonly buffer Sharing { uint sharing[]; };
layout(binding = 6, rgba32f) uniform image2DArray direct_image;
layout(binding = 7, std430) writeonly buffer Rays { uint rays[]; };
layout(binding = 8, std430) buffer Arguments { uint arguments[4]; };
layout(binding = 9, rgba32ui) uniform uimage2DArray known_image;

#include "common/append.glsl"
#include "common/camera.glsl"
#include "common/lights.glsl"
#include "common/surface.glsl"

const uint LEFT = 0u;
const uint RIGHT = 1u;
// How far off the pixel's plane a tap may lie, as a share of the distance from the eye.
const float PLANE_TOLERANCE = 0.003;
// The triangle of depth samples (Zhang & Green): their distance from the centre, in pixels, and how much nearer a sample must
// be, relative to the distance, to count as an edge.
const float TRIANGLE_PIXELS = 2.0;
const float TRIANGLE_TOLERANCE = 0.01;
// How far such a sample must shift against the surface between the eyes, pixels.
const float LEAST_SHIFT = 0.5;
// Taps of less bilinear weight are skipped. Otherwise rounding would add such taps even where both eyes are at the same place.
const float LEAST_WEIGHT = 0.01;
// Relative to the light: how much the taps may differ, which bounds the error of the interpolation; and how much the light may
// change between the eyes, by the bound in `share`. With these values fewer than 0.5 % of the pixels are off by more than 2 %
// (docs/rendering.md).
const float MOST_SPREAD = 0.04;
const float MOST_CHANGE = 0.04;

float largest(vec3 c) { return max(c.x, max(c.y, c.z)); }

// Whether an edge is near. The right eye sees `position` at the centre of pixel `at`, the left eye at `pixel`. There is an edge
// if the left eye sees something near `pixel` that is nearer than `position`, lies before the surface's plane, and is shifted
// against `position` in the right eye.
bool near_edge(vec3 position, vec3 face_normal, vec2 pixel, ivec2 at) {
    float reach = length(position - eye_position(LEFT));
    for (int k = 0; k < 3; ++k) {
        float phi = 2.0 * PI * (float(k) + 0.25) / 3.0;
        ivec2 there = ivec2(floor(pixel + TRIANGLE_PIXELS * vec2(cos(phi), sin(phi))));
        if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, ivec2(frame.size)))) continue;
        float depth = texelFetch(depth_image, ivec3(there, LEFT), 0).x;
        if (depth == 0.0) continue;
        vec3 sampled = render_position(LEFT, vec2(there) + 0.5, depth);
        bool nearer = length(sampled - eye_position(LEFT)) < reach * (1.0 - TRIANGLE_TOLERANCE);
        if (nearer && dot(sampled - position, face_normal) > reach * TRIANGLE_TOLERANCE) {
            vec2 right = screen_from_clip(frame.eyes[RIGHT].clip_from_render * vec4(sampled, 1.0)).xy;
            if (distance(right - (vec2(at) + 0.5), vec2(there) + 0.5 - pixel) > LEAST_SHIFT) return true;
        }
    }
    return false;
}

// Whether a pixel of the right eye can take its light from the left eye; `direct` receives it. Where it cannot, `known`
// receives what the left eye knows of the pixel's lights (known_lights.glsl).
bool share(ivec2 at, float depth, out vec3 direct, out uvec4 known) {
    known = uvec4(0u);
    direct = vec3(0.0);
    uint instance = texelFetch(instance_image, ivec3(at, RIGHT), 0).x;
    if (instance == 0u || sharing[instance - 1u] == 0u) return false;
    Surface s = unpack_surface(texelFetch(surface_image, ivec3(at, RIGHT), 0));
    vec3 position = render_position(RIGHT, vec2(at) + 0.5, depth);
    vec4 clip = frame.eyes[LEFT].clip_from_render * vec4(position, 1.0);
    if (clip.w <= 0.0) return false;
    vec2 pixel = screen_from_clip(clip).xy;
    if (any(lessThan(pixel, vec2(0.0))) || any(greaterThanEqual(pixel, vec2(frame.size)))) return false;
    if (near_edge(position, s.face_normal, pixel, at)) return false;

    float off_plane = PLANE_TOLERANCE * length(position - eye_position(RIGHT));
    vec2 corner = floor(pixel - 0.5), f = pixel - 0.5 - corner;
    vec3 normal = vec3(0.0), diffuse = vec3(0.0), rest = vec3(0.0);
    vec3 low = vec3(FLT_MAX), high = vec3(0.0);
    float roughness = 0.0, weights = 0.0;
    uvec4 known_there = uvec4(~0u);
    for (int k = 0; k < 4; ++k) {
        ivec2 step = ivec2(k & 1, k >> 1);
        vec2 w = mix(1.0 - f, f, vec2(step));
        float weight = w.x * w.y;
        if (weight < LEAST_WEIGHT) continue;
        ivec2 there = ivec2(corner) + step;
        if (any(lessThan(there, ivec2(0))) || any(greaterThanEqual(there, ivec2(frame.size)))) return false;
        ivec3 tap = ivec3(there, LEFT);
        if (texelFetch(instance_image, tap, 0).x != instance) return false;
        vec3 p = render_position(LEFT, vec2(there) + 0.5, texelFetch(depth_image, tap, 0).x);
        if (!(abs(dot(p - position, s.face_normal)) <= off_plane)) return false;
        Surface t = unpack_surface(texelFetch(surface_image, tap, 0));
        vec3 tap_diffuse = texelFetch(diffuse_image, there, 0).rgb;
        vec3 tap_rest = imageLoad(direct_image, tap).rgb - t.albedo * tap_diffuse;
        if (SHADOWS != 0u) known_there &= imageLoad(known_image, tap);
        vec3 seen = tap_rest + s.albedo * tap_diffuse;
        low = min(low, seen);
        high = max(high, seen);
        diffuse += weight * tap_diffuse;
        rest += weight * tap_rest;
        normal += weight * t.normal;
        roughness += weight * t.roughness;
        weights += weight;
    }
    // The pixel and its taps show the same place, so that the same matter lies between them and each light.
    known = known_there;
    diffuse /= weights;
    rest /= weights;
    roughness /= weights;
    vec3 total = rest + s.albedo * diffuse;
    float light = largest(total);
    if (!(largest(high - low) <= MOST_SPREAD * light)) return false;
    // fp16 clamps a larger diffuse part.
    if (largest(diffuse) >= 65504.0) return false;

    // The logarithm of GGX changes by at most 2/α per radian of the half vector, which turns half as far as the direction to the
    // eye, and as far as the normal. It changes by at most 4/r per unit of the roughness r. The diffuse part changes with the
    // normal alone.
    float to_eye = distance(normalize(eye_position(LEFT) - position), normalize(eye_position(RIGHT) - position));
    float turned = distance(normalize_or(normal, s.normal), s.normal);
    float r = max(s.roughness, PUNCTUAL_ROUGHNESS);
    float change = (to_eye + 2.0 * turned) / square(r) + 4.0 * abs(roughness - s.roughness) / r;
    float specular = largest(max(rest, vec3(0.0)));
    if (!(specular * (exp(change) - 1.0) + 2.0 * turned * light <= MOST_CHANGE * light)) return false;
    direct = max(total, vec3(0.0));
    return true;
}

// The numbers of listed pixels of whose lights nothing is known, and of those of whose lights something is known.
shared uint unknown_count;
shared uint known_count;
shared uint first;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (gl_LocalInvocationIndex == 0u) {
        unknown_count = 0u;
        known_count = 0u;
    }
    barrier();
    bool left_over = false;
    uvec4 known = uvec4(0u);
    if (all(lessThan(id.xy, frame.size))) {
        ivec3 texel = ivec3(id.xy, RIGHT);
        float depth = texelFetch(depth_image, texel, 0).x;
        vec3 direct;
        if (depth > 0.0) {
            if (share(texel.xy, depth, direct, known)) {
                imageStore(direct_image, texel, vec4(direct, 1.0));
            } else {
                left_over = true;
                if (SHADOWS != 0u) imageStore(known_image, texel, known);
            }
        }
    }
    // Neighbours in the list run in the same subgroup. Pixels that will trace many rays are therefore listed apart from those
    // that will trace few.
    bool is_known = any(notEqual(known, uvec4(0u)));
    uint place = 0u;
    if (left_over) place = is_known ? atomicAdd(known_count, 1u) : atomicAdd(unknown_count, 1u);
    barrier();
    uint count = unknown_count + known_count;
    if (gl_LocalInvocationIndex == 0u && count > 0u) MAKE_ROOM(arguments, count, first)
    barrier();
    if (left_over) {
        if (is_known) place += unknown_count;
        rays[first + place] = id.x | id.y << 14 | RIGHT << 28;
    }
}
