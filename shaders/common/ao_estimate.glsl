// Obscurance of one pixel from what the views show around it, after HBAO+ (Bavoil, NVIDIA) and Alchemy (McGuire et al.
// 2011). The samples lie on a disk in world space about the pixel's position, parallel to its eye's image. The surface that an
// eye shows at a sample hides more of the surroundings the higher it rises above the pixel's plane, and less the farther away
// it is. d is the vector to that surface:
//     o = max(n·d/|d| − BIAS, 0)/(1 − BIAS) · max(1 − |d|²/radius², 0)        visibility = 1 − STRENGTH · mean of o
// With STEREO each sample is looked up in both views (Shi et al. 2022). Where each of the two surfaces found is seen by both
// eyes, o is the mean of the two values; otherwise it is the larger one.
// Needs `frame`, STEREO, `depth_image`, `surface_image`, with STEREO `pair_image`, and `radius` (metres).
#ifndef AO_ESTIMATE_GLSL
#define AO_ESTIMATE_GLSL
#include "ao.glsl"
#include "camera.glsl"
#include "math.glsl"
#include "random.glsl"

const uint SAMPLES = 16u;
// Sine of the elevation above the plane below which a surface hides nothing. It keeps the facets of round meshes invisible.
const float BIAS = 0.1;
// Makes the mean of the estimate equal to the mean of what rays find (docs/rendering.md says where it was measured).
const float STRENGTH = 4.0;
// Angle between successive samples, radians: the golden angle.
const float TURN = 2.39996323;
// Purposes of a pixel's random numbers.
const uint DRAW_TURN = 16u;
const uint DRAW_JITTER = 17u;

// The disk as an eye sees it: the clip-space x, y and w of its centre and of its two half axes.
struct Disk {
    int eye;
    vec3 middle;
    vec3 across;
    vec3 down;
    EyeRays rays;
};

Disk disk_in(int eye, vec3 position, vec3 across, vec3 down) {
    mat4 clip = frame.eyes[eye].clip_from_render;
    return Disk(eye, (clip * vec4(position, 1.0)).xyw, (clip * vec4(across, 0.0)).xyw, (clip * vec4(down, 0.0)).xyw,
                eye_rays(uint(eye)));
}

struct Place {
    vec3 position;
    vec3 normal;
    float nearest2;     // squared distance, m²; what is nearer is the place itself
};

// x: how much the surface that the eye shows at a sample hides; y: 1 where the other eye sees that surface too.
vec2 hidden(Disk d, Place p, vec2 offset) {
    vec3 clip = d.middle + offset.x * d.across + offset.y * d.down;
    if (clip.z < d.rays.near) return vec2(0.0);
    vec2 pixel = (vec2(clip.x, -clip.y) / clip.z * 0.5 + 0.5) * vec2(frame.size);
    if (any(lessThan(pixel, vec2(0.0))) || any(greaterThanEqual(pixel, vec2(frame.size)))) return vec2(0.0);
    ivec3 texel = ivec3(ivec2(pixel), d.eye);
    float depth, both = 0.0;
    if (STEREO != 0u) {
        uvec2 word = texelFetch(pair_image, texel, 0).xy;
        depth = uintBitsToFloat(word.x);
        both = (word.y & PAIRED) != 0u ? 1.0 : 0.0;
    } else {
        depth = texelFetch(depth_image, texel, 0).x;
    }
    if (depth == 0.0) return vec2(0.0);
    vec3 to = position_along(d.rays, vec2(texel.xy) + 0.5, depth) - p.position;
    float distance2 = dot(to, to);
    if (distance2 <= p.nearest2) return vec2(0.0, both);
    float height = max(dot(p.normal, to) * inversesqrt(distance2) - BIAS, 0.0) * (1.0 / (1.0 - BIAS));
    return vec2(height * max(1.0 - distance2 / (radius * radius), 0.0), both);
}

float visibility(ivec3 texel, float depth) {
    vec3 position = render_position(texel.z, vec2(texel.xy) + 0.5, depth);
    vec3 normal = unpack_direction(texelFetch(surface_image, texel, 0).y);
    float half_pixel = 0.5 * pixel_size(texel.z) * view_distance(texel.z, depth);
    Place p = Place(position, normal, half_pixel * half_pixel);
    vec3 across = radius * normalize(frame.eyes[texel.z].ray_across.xyz);
    vec3 down = radius * normalize(frame.eyes[texel.z].ray_down.xyz);
    Disk own = disk_in(texel.z, position, across, down), other;
    if (STEREO != 0u) other = disk_in(1 - texel.z, position, across, down);
    uint token = frame.eyes[texel.z].stream.x, seed = combine(frame.seed, frame.frame);
    float turn = 2.0 * PI * lattice_1d(seed, token, uvec2(texel.xy), 0u, DRAW_TURN);
    float jitter = draw_1d(seed, token, uvec2(texel.xy), 0u, DRAW_JITTER);
    float sum = 0.0;
    for (uint i = 0u; i < SAMPLES; ++i) {
        // The samples are evenly spaced in radius, not in area, because near surfaces hide most.
        float r = (float(i) + jitter) * (1.0 / float(SAMPLES)), angle = turn + TURN * float(i);
        vec2 offset = r * vec2(cos(angle), sin(angle));
        vec2 mine = hidden(own, p, offset);
        if (STEREO != 0u) {
            vec2 theirs = hidden(other, p, offset);
            sum += mine.y * theirs.y > 0.0 ? 0.5 * (mine.x + theirs.x) : max(mine.x, theirs.x);
        } else {
            sum += mine.x;
        }
    }
    return clamp(1.0 - STRENGTH * sum * (1.0 / float(SAMPLES)), 0.0, 1.0);
}

#endif
