#version 460
// In: radiance without reflections, reflections, G-buffer; with antialiasing also the view's finer twin. Out: linear radiance
// and reflection (stills), and the tone-mapped sRGB picture. The tone map is Khronos' PBR Neutral, which leaves colours below
// 0.8 as they are.
// Antialiasing: surfaces and their light are drawn with FINER samples along each side of a pixel and averaged, but reflections
// have one value per pixel. Each sample takes the reflection of its own pixel, or of a neighbour that shows its surface.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// 1: a reflection was made; 0: nothing in view reflects.
layout(constant_id = 0) const uint HAS_REFLECTION = 1u;
// 1: the linear images are written (stills).
layout(constant_id = 1) const uint WANT_LINEAR = 1u;

// 1: the right eye's reflections are mirrored left to right (catch trials).
layout(constant_id = 2) const uint UNRELATED = 0u;
// Samples along each side of a pixel; 1: no antialiasing.
layout(constant_id = 3) const uint FINER = 1u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) buffer Counters { CountersData counters; };
layout(binding = 2) uniform usampler2DArray surface_image;
layout(binding = 3) uniform sampler2DArray depth_image;
layout(binding = 4) uniform sampler2DArray radiance_image;
layout(binding = 5) uniform sampler2DArray reflection_image;
layout(binding = 6, rgba8) writeonly uniform image2DArray display_image;
layout(binding = 7, rgba32f) writeonly uniform image2DArray linear_image;
layout(binding = 8, rgba32f) writeonly uniform image2DArray reflection_out;

layout(binding = 9) uniform usampler2DArray instance_image;
layout(binding = 10) uniform usampler2DArray fine_surface_image;
layout(binding = 11) uniform sampler2DArray fine_depth_image;
layout(binding = 12) uniform usampler2DArray fine_instance_image;
layout(binding = 13) uniform sampler2DArray fine_radiance_image;

#include "common/camera.glsl"

// Whether the reflection of a pixel was written: pixels without a ray have none.
bool reflects(ivec3 texel) {
    if (texelFetch(depth_image, texel, 0).x == 0.0 || !is_shown(texel.xy)) return false;
    return unpack_roughness(texelFetch(surface_image, texel, 0)) <= frame.ray_roughness_limit;
}

vec3 pbr_neutral(vec3 c) {
    const float start = 0.8 - 0.04, desaturation = 0.15;
    float x = min(c.r, min(c.g, c.b));
    float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
    c -= offset;
    float peak = max(c.r, max(c.g, c.b));
    if (peak < start) return c;
    float d = 1.0 - start;
    float new_peak = 1.0 - d * d / (peak + d - start);
    c *= new_peak / peak;
    float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(c, vec3(new_peak), g);
}

vec3 srgb(vec3 c) {
    vec3 high = 1.055 * pow(max(c, vec3(0.0)), vec3(1.0 / 2.4)) - 0.055;
    return mix(high, 12.92 * c, lessThanEqual(c, vec3(0.0031308)));
}

// The reflection that is added to a pixel's light; with UNRELATED that of the mirrored pixel in the right eye.
vec3 reflection_of(ivec3 texel) {
    if (HAS_REFLECTION == 0u || !reflects(texel)) return vec3(0.0);
    ivec3 from = texel;
    if (UNRELATED != 0u && texel.z == 1) from.x = int(frame.size.x) - 1 - texel.x;
    return reflects(from) ? texelFetch(reflection_image, from, 0).rgb : vec3(0.0);
}

// How different a pixel's surface is from a fine sample's: 0 at the same place, 1 or more for another surface.
float unlike(ivec3 texel, uint instance, vec3 normal, float depth) {
    if (!reflects(texel)) return 1e9;
    float other = texelFetch(instance_image, texel, 0).x == instance ? 0.0 : 4.0;
    vec3 n = unpack_direction(texelFetch(surface_image, texel, 0).x);
    float there = texelFetch(depth_image, texel, 0).x;
    return other + 4.0 * (1.0 - dot(n, normal)) + 10.0 * abs(depth - there) / max(depth, there);
}

vec3 antialiased(ivec3 texel) {
    vec3 sum = vec3(0.0);
    ivec2 last = ivec2(frame.size) - 1;
    for (int k = 0; k < int(FINER * FINER); ++k) {
        ivec3 fine = ivec3(texel.xy * int(FINER) + ivec2(k % int(FINER), k / int(FINER)), texel.z);
        sum += texelFetch(fine_radiance_image, fine, 0).rgb;
        float depth = texelFetch(fine_depth_image, fine, 0).x;
        if (HAS_REFLECTION == 0u || depth == 0.0) continue;
        uvec4 surface = texelFetch(fine_surface_image, fine, 0);
        if (unpack_roughness(surface) > frame.ray_roughness_limit) continue;
        uint instance = texelFetch(fine_instance_image, fine, 0).x;
        vec3 normal = unpack_direction(surface.x);
        ivec3 best = texel;
        float least = unlike(texel, instance, normal, depth);
        // Usually the sample's own pixel shows the same surface; at an edge the most similar of its neighbours is taken.
        for (int j = 0; least >= 1.0 && j < 9; ++j) {
            ivec3 near = ivec3(clamp(texel.xy + ivec2(j % 3, j / 3) - 1, ivec2(0), last), texel.z);
            float of = unlike(near, instance, normal, depth);
            if (of < least) {
                least = of;
                best = near;
            }
        }
        if (least < 1e9) sum += reflection_of(best);
    }
    return sum / float(FINER * FINER);
}

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    vec3 reflection = reflection_of(texel);
    vec3 sum = FINER != 1u ? antialiased(texel) : texelFetch(radiance_image, texel, 0).rgb + reflection;
    if (any(isnan(sum))) atomicAdd(counters.nan, 1u);
    if (any(isinf(sum))) atomicAdd(counters.inf, 1u);
    if (WANT_LINEAR != 0u) {
        imageStore(linear_image, texel, vec4(sum, 1.0));
        imageStore(reflection_out, texel, vec4(reflection, 0.0));
    }
    if (!is_shown(texel.xy)) return;
    ivec3 shown = ivec3(texel.xy - ivec2(frame.guard), texel.z);
    imageStore(display_image, shown, vec4(srgb(pbr_neutral(sum * frame.exposure)), 1.0));
}
