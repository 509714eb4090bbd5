#version 460
// In: radiance without reflections, reflections, G-buffer. Out: linear radiance and reflection (stills), and the
// tone-mapped sRGB picture. The tone map is Khronos' PBR Neutral: colours below 0.8 stay as they are.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"
#include "common/surface.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// 1: a reflection was made; 0: nothing in view reflects.
layout(constant_id = 0) const uint HAS_REFLECTION = 1u;
// 1: the linear images are wanted (stills).
layout(constant_id = 1) const uint WANT_LINEAR = 1u;

// 1: the right eye's reflections are exchanged left and right (catch trials).
layout(constant_id = 2) const uint UNRELATED = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) buffer Counters { CountersData counters; };
layout(binding = 2) uniform usampler2DArray surface_image;
layout(binding = 3) uniform sampler2DArray depth_image;
layout(binding = 4) uniform sampler2DArray radiance_image;
layout(binding = 5) uniform sampler2DArray reflection_image;
layout(binding = 6, rgba8) writeonly uniform image2DArray display_image;
layout(binding = 7, rgba32f) writeonly uniform image2DArray linear_image;
layout(binding = 8, rgba32f) writeonly uniform image2DArray reflection_out;

#include "common/camera.glsl"

// Pixels without a ray were never written.
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

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    vec4 reflection = vec4(0.0);
    if (HAS_REFLECTION != 0u && reflects(texel)) {
        ivec3 from = texel;
        if (UNRELATED != 0u && texel.z == 1) from.x = int(frame.size.x) - 1 - texel.x;
        if (reflects(from)) reflection = texelFetch(reflection_image, from, 0);
    }
    vec3 sum = texelFetch(radiance_image, texel, 0).rgb + reflection.rgb;
    if (any(isnan(sum))) atomicAdd(counters.nan, 1u);
    if (any(isinf(sum))) atomicAdd(counters.inf, 1u);
    if (WANT_LINEAR != 0u) {
        imageStore(linear_image, texel, vec4(sum, 1.0));
        imageStore(reflection_out, texel, reflection);
    }
    if (!is_shown(texel.xy)) return;
    ivec3 shown = ivec3(texel.xy - ivec2(frame.guard), texel.z);
    imageStore(display_image, shown, vec4(srgb(pbr_neutral(sum * frame.exposure)), 1.0));
}
