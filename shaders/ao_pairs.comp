#version 460
// In: G-buffer. Out: for each pixel, in one texel, its depth and the other eye's pixel that shows the same place. The pair is
// found by reprojection with a check that it leads back (seed 001, its fig. 5; Nehab et al. 2007).
// In each pair one pixel is estimated and the other one copies its value. The seed estimates in the left view. Here the eye
// that is nearer to the place is estimated, so that exchanging the eyes exchanges the pictures. Where both eyes are equally
// near, both are estimated.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform usampler2DArray surface_image;
layout(binding = 2) uniform sampler2DArray depth_image;
layout(binding = 3, rg32ui) writeonly uniform uimage2DArray pair_image;

#include "common/ao.glsl"
#include "common/camera.glsl"
#include "common/math.glsl"

// When two pixels show the same place: the least cosine between the triangles' normals, the largest distance from the plane
// relative to the distance along the view's axis, and the largest distance, in pixels, between the pixel's centre and where
// the pair leads back (half a pixel's diagonal each way, rounded up).
const float LEAST_COSINE = 0.9;
const float PLANE_TOLERANCE = 0.01;
const float MOST_OFF = 1.5;

vec3 face_normal(ivec3 texel) { return unpack_direction(texelFetch(surface_image, texel, 0).y); }

bool seen_at(vec3 position, int eye, out vec2 pixel) {
    vec4 clip = frame.eyes[eye].clip_from_render * vec4(position, 1.0);
    pixel = screen_from_clip(clip).xy;
    return clip.w > 0.0 && all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, vec2(frame.size)));
}

// Whether the eye is at least as near to the place as the other eye.
bool leads(vec3 position, int eye) {
    vec3 own = position - eye_position(eye), other = position - eye_position(1 - eye);
    return dot(own, own) <= dot(other, other);
}

uint find_pair(ivec3 texel, float depth) {
    vec3 position = render_position(texel.z, vec2(texel.xy) + 0.5, depth);
    vec3 normal = face_normal(texel);
    int other = 1 - texel.z;
    vec2 pixel, back;
    if (!seen_at(position, other, pixel)) return 0u;
    ivec3 there = ivec3(ivec2(pixel), other);
    float depth_there = texelFetch(depth_image, there, 0).x;
    if (depth_there == 0.0) return 0u;
    vec3 position_there = render_position(other, vec2(there.xy) + 0.5, depth_there);
    if (abs(dot(position_there - position, normal)) > PLANE_TOLERANCE * view_distance(texel.z, depth)) return 0u;
    if (dot(face_normal(there), normal) < LEAST_COSINE) return 0u;
    if (!seen_at(position_there, texel.z, back) || distance(back, vec2(texel.xy) + 0.5) > MOST_OFF) return 0u;
    bool copies = !leads(position, texel.z) && leads(position_there, other);
    return uint(there.x) | uint(there.y) << 14 | PAIRED | (copies ? COPIES : 0u);
}

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    // All invocations of a group belong to one eye, so that a software device loads the eye's constants once for all lanes.
    ivec3 texel = ivec3(id.xy, gl_WorkGroupID.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    uint pair = depth > 0.0 ? find_pair(texel, depth) : 0u;
    imageStore(pair_image, texel, uvec4(floatBitsToUint(depth), pair, 0u, 0u));
}
