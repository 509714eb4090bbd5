#version 460
// In: hits, radiance, G-buffer. Out: the outgoing reflection of each listed pixel; alpha = how much of it is known.
// Spatial reuse over 5×5 pixels as a ratio estimator with the BRDF in it (Stachowiak 2015):
// L = Σ L_i·f_i·cos_i/p_i / Σ f_i·cos_i/p_i, per channel, times the lobe's own albedo F0·A + B.
// Unknown rays take the fallback's share: C·L + (1 − C)·fallback with C = Σ w·c/Σ w.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;
// 0: only the own sample (a study's "no reuse"); 2 is the paper's radius.
layout(constant_id = 0) const uint RADIUS = 2u;
// 1: several samples a pixel, summed over dispatches in one ratio.
layout(constant_id = 1) const uint SUMS = 0u;

layout(binding = 0, std430) readonly buffer Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform usampler2DArray instance_image;
layout(binding = 6) uniform sampler2DArray depth_image;
layout(binding = 7) uniform usampler2DArray hit_image;
layout(binding = 8) uniform sampler2DArray radiance_image;
layout(binding = 9) uniform sampler2D environment_map;
layout(binding = 10) uniform sampler2D irradiance_map;
layout(binding = 11) uniform sampler2D specular_map;
layout(binding = 12) uniform sampler2D brdf_table;
layout(binding = 13, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 14, rgba16f) writeonly uniform image2DArray reflection_image;
layout(binding = 15, rgba32f) uniform image2DArray sum_image;
layout(binding = 16, rgba32f) uniform image2DArray weight_image;
layout(push_constant) uniform Constants { uint first; uint last; };

#include "common/camera.glsl"
#include "common/hit.glsl"
#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/shade.glsl"
#include "common/store.glsl"

// Same surface for the purpose of reuse: cosine between normals, distance from the plane relative to the view's.
const float LEAST_COSINE = 0.9;
const float PLANE_TOLERANCE = 0.01;

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uint eye = uint(texel.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    uint instance = texelFetch(instance_image, texel, 0).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    float plane_tolerance = PLANE_TOLERANCE * view_distance(eye, depth);
    bool mirror = is_mirror(s);
    int radius = mirror ? 0 : int(RADIUS);

    vec3 sum = vec3(0.0);         // Σ w·c·L
    vec3 known = vec3(0.0);       // Σ w·c
    vec2 shares = vec2(0.0);      // Σ w·c and Σ w as luminances
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            ivec3 tap = texel + ivec3(x, y, 0);
            if (any(lessThan(tap.xy, ivec2(0))) || any(greaterThanEqual(tap.xy, ivec2(frame.size)))) continue;
            vec3 from = position;
            if (x != 0 || y != 0) {
                if (texelFetch(instance_image, tap, 0).x != instance) continue;
                uvec4 packed = texelFetch(surface_image, tap, 0);
                float r = unpack_roughness(packed);
                if (r > frame.ray_roughness_limit || r < frame.delta_roughness) continue;
                if (dot(unpack_direction(packed.x), s.normal) < LEAST_COSINE) continue;
                from = render_position(eye, vec2(tap.xy) + 0.5, texelFetch(depth_image, tap, 0).x);
                if (abs(dot(from - position, s.face_normal)) > plane_tolerance) continue;
            }
            uvec4 word = texelFetch(hit_image, tap, 0);
            if (hit_status(word) == NOTHING) continue;
            Hit h = unpack_hit(word);
            vec3 l = h.direction;
            if (h.status == HIT && (x != 0 || y != 0)) l = normalize_or(from + h.direction * h.distance - position, l);
            if (dot(l, s.face_normal) <= 0.0) continue;
            vec3 w = reflection_weight(s, v, l, h.pdf);
            vec3 radiance = vec3(0.0);
            if (h.status == HIT) {
                ivec2 at = min(ivec2(h.uv * vec2(frame.size)), ivec2(frame.size) - 1);
                radiance = texelFetch(radiance_image, ivec3(at, h.eye), 0).rgb;
            } else if (h.status == SKY) {
                radiance = environment_radiance(h.direction);
            }
            if (frame.firefly != 0u) w /= 1.0 + luminance(radiance);
            sum += w * h.confidence * radiance;
            known += w * h.confidence;
            shares += luminance(w) * vec2(h.confidence, 1.0);
        }
    }
    if (SUMS != 0u) {
        if (first == 0u) {
            vec4 earlier_sum = imageLoad(sum_image, texel), earlier_weight = imageLoad(weight_image, texel);
            sum += earlier_sum.rgb;
            known += earlier_weight.rgb;
            shares += vec2(earlier_sum.a, earlier_weight.a);
        }
        imageStore(sum_image, texel, vec4(sum, shares.x));
        imageStore(weight_image, texel, vec4(known, shares.y));
        if (last == 0u) return;
    }
    float confidence = shares.y > 0.0 ? shares.x / shares.y : 0.0;
    // Where a channel has hardly any weight, the ratio of luminances is the steadier one.
    vec3 ratio = sum / max(known, vec3(1e-6));
    if (any(lessThan(known, vec3(1e-6)))) ratio = vec3(luminance(sum) / max(luminance(known), 1e-12));
    if (shares.x <= 0.0) ratio = vec3(0.0);
    float nv = max(dot(s.normal, v), 1e-4);
    vec3 fallback = frame.fallback != 0u ? environment_specular(reflect(-v, s.normal), s.roughness) : vec3(0.0);
    vec3 radiance = mix(fallback, ratio, confidence) * specular_albedo(s.f0, nv, s.roughness);
    imageStore(reflection_image, texel, vec4(storable(radiance), confidence));
}
