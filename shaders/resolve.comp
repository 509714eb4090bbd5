#version 460
// In: hits, radiance, G-buffer. Out: the outgoing reflection of each listed pixel; alpha = how much of it is known.
// Spatial reuse over 5×5 pixels as a ratio estimator with the BRDF in it (Stachowiak 2015):
// L = Σ L_i·f_i·cos_i/p_i / Σ f_i·cos_i/p_i, per channel, times the lobe's own albedo F0·A + B.
// Unknown rays take the fallback's share: C·L + (1 − C)·fallback with C = Σ w·c/Σ w.
// With FOR_PAIRS the other eye has a say (reproject.comp): out go the known share of the light, C·L and C, what it
// weighs, and how far away the pixel's reflection stands.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;
// Squared; 0: only the own sample (a study's "no reuse"); 8 is the paper's 5×5.
layout(constant_id = 0) const uint RADIUS_SQUARED = 8u;
// 1: several samples a pixel, summed over dispatches in one ratio.
layout(constant_id = 1) const uint SUMS = 0u;
layout(constant_id = 2) const uint FOR_PAIRS = 0u;
// 1: the right eye traces nothing and knows nothing.
layout(constant_id = 3) const uint ONE_EYE = 0u;
// 1: each ray brought its own radiance, at its own pixel; 0: a hit's radiance is that of the pixel it hit.
layout(constant_id = 4) const uint OWN_RADIANCE = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform usampler2DArray guide_image;
layout(binding = 6) uniform usampler2DArray hit_image;
layout(binding = 7) uniform sampler2DArray radiance_image;
layout(binding = 8) uniform sampler2D environment_map;
layout(binding = 9) uniform sampler2D irradiance_map;
layout(binding = 10) uniform sampler2D specular_map;
layout(binding = 11) uniform sampler2D brdf_table;
layout(binding = 12, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 13, rgba16f) writeonly uniform image2DArray reflection_image;
layout(binding = 14, rgba32f) uniform image2DArray sum_image;
layout(binding = 15, rgba32f) uniform image2DArray weight_image;
// x: Σ w; y: see reproject.comp.
layout(binding = 16, rg32f) uniform image2DArray standing_image;
layout(push_constant) uniform Constants { uint first; uint last; };

#include "common/ray_list.glsl"
#include "common/hit.glsl"
#include "common/reflect.glsl"
#include "common/shade.glsl"
#include "common/outgoing.glsl"
#include "common/store.glsl"

struct Sums {
    vec3 light;      // Σ w·c·L
    vec3 known;      // Σ w·c
    vec2 shares;     // Σ w·c and Σ w as luminances
    float nearness;  // Σ w·c/(distance along the ray from the eye over the surface to what it hit)
};

// A neighbour's hit that may stand in for p's.
struct Tap {
    bool usable;
    vec3 from;       // where its ray starts
    uvec4 word;
};

Tap load_tap(Pixel p, ivec3 texel, EyeRays rays_of_eye) {
    Tap tap = Tap(false, p.position, uvec4(0u));
    if (texel != p.texel) {
        if (any(lessThan(texel.xy, ivec2(0))) || any(greaterThanEqual(texel.xy, ivec2(frame.size)))) return tap;
        Guide g = load_guide(texel);
        tap.from = position_along(rays_of_eye, vec2(texel.xy) + 0.5, g.depth);
        if (!same_surface(p, g, tap.from)) return tap;
    }
    tap.word = texelFetch(hit_image, texel, 0);
    tap.usable = contributes(tap.word);
    return tap;
}

vec3 tap_radiance(Hit h, ivec3 texel) {
    if (OWN_RADIANCE != 0u) return texelFetch(radiance_image, texel, 0).rgb;
    if (h.status == SKY) return environment_radiance(h.direction);
    ivec2 at = min(ivec2(h.uv * vec2(frame.size)), ivec2(frame.size) - 1);
    return texelFetch(radiance_image, ivec3(at, h.eye), 0).rgb;
}

void add(inout Sums sums, Pixel p, float eye_distance, Tap tap, ivec3 texel) {
    Hit h = unpack_hit(tap.word);
    vec3 l = h.direction;
    float far = frame.ray_length;
    if (h.status == HIT) {
        vec3 to_hit = tap.from + h.direction * h.distance - p.position;
        far = length(to_hit);
        l = far > 0.0 ? to_hit / far : l;
    }
    vec3 w = reflection_weight(p.surface, p.v, l, h.pdf);
    // Below the triangle's horizon a direction is known to be black, as in the reference.
    bool open = dot(l, p.surface.face_normal) > 0.0;
    vec3 radiance = vec3(0.0);
    if (open && (h.status == HIT || h.status == SKY)) radiance = tap_radiance(h, texel);
    if (frame.firefly != 0u) w /= 1.0 + luminance(radiance);
    float share = luminance(w);
    sums.light += w * h.confidence * radiance;
    sums.known += w * h.confidence;
    sums.shares += share * vec2(h.confidence, 1.0);
    if (FOR_PAIRS != 0u) sums.nearness += share * h.confidence / (eye_distance + far);
}

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    if (ONE_EYE != 0u && texel.z == 1) {
        imageStore(reflection_image, texel, vec4(0.0));
        imageStore(standing_image, texel, vec4(0.0));
        return;
    }
    Pixel p = load_pixel(texel);
    // A mirror's one direction is its own.
    int reach = is_mirror(p.surface) ? 0 : int(RADIUS_SQUARED);
    int radius = int(sqrt(float(reach) + 0.5));
    EyeRays rays_of_eye = eye_rays(uint(texel.z));
    float eye_distance = FOR_PAIRS != 0u ? distance(eye_position(uint(texel.z)), p.position) : 0.0;
    Sums sums = Sums(vec3(0.0), vec3(0.0), vec2(0.0), 0.0);
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            if (x * x + y * y > reach) continue;
            ivec3 at = texel + ivec3(x, y, 0);
            Tap tap = load_tap(p, at, rays_of_eye);
            if (tap.usable) add(sums, p, eye_distance, tap, at);
        }
    }
    if (SUMS != 0u) {
        if (first == 0u) {
            vec4 earlier_sum = imageLoad(sum_image, texel), earlier_weight = imageLoad(weight_image, texel);
            sums.light += earlier_sum.rgb;
            sums.known += earlier_weight.rgb;
            sums.shares += vec2(earlier_sum.a, earlier_weight.a);
            if (FOR_PAIRS != 0u) sums.nearness += imageLoad(standing_image, texel).y;
        }
        imageStore(sum_image, texel, vec4(sums.light, sums.shares.x));
        imageStore(weight_image, texel, vec4(sums.known, sums.shares.y));
        if (last == 0u) {
            if (FOR_PAIRS != 0u) imageStore(standing_image, texel, vec4(0.0, sums.nearness, 0.0, 0.0));
            return;
        }
    }
    float confidence = sums.shares.y > 0.0 ? sums.shares.x / sums.shares.y : 0.0;
    // Where a channel has hardly any weight, the ratio of luminances is the steadier one.
    vec3 steady = vec3(luminance(sums.light) / max(luminance(sums.known), 1e-12));
    vec3 ratio = mix(sums.light / max(sums.known, vec3(1e-6)), steady, lessThan(sums.known, vec3(1e-6)));
    if (sums.shares.x <= 0.0) ratio = vec3(0.0);
    vec3 light = ratio * confidence;
    if (FOR_PAIRS == 0u) light = outgoing(p, light, confidence);
    imageStore(reflection_image, texel, vec4(storable(light), confidence));
    float nearness = sums.shares.x > 0.0 ? sums.nearness / sums.shares.x : 0.0;
    if (FOR_PAIRS != 0u) imageStore(standing_image, texel, vec4(sums.shares.y, nearness, 0.0, 0.0));
}
