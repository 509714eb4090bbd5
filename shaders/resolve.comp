#version 460
// In: hits, radiance, G-buffer. Out: the outgoing reflection of each listed pixel; alpha = how much of it is known.
// Spatial reuse over 5×5 pixels as a ratio estimator with the BRDF in it (Stachowiak 2015):
// L = Σ L_i·f_i·cos_i/p_i / Σ f_i·cos_i/p_i, per channel, times the lobe's own albedo F0·A + B.
// Unknown rays take the fallback's share: C·L + (1 − C)·fallback with C = Σ w·c/Σ w.
// With REPROJECT (paper §4.3) the taps are shared with the other eye's pixel that shows the same reflection: half of
// the pattern from each eye, and where two pixels are each other's partner the same set for both, with the same noise.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;
// 0: only the own sample (a study's "no reuse"); 2 is the paper's radius.
layout(constant_id = 0) const uint RADIUS = 2u;
// 1: several samples a pixel, summed over dispatches in one ratio.
layout(constant_id = 1) const uint SUMS = 0u;
layout(constant_id = 2) const uint REPROJECT = 0u;

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
layout(push_constant) uniform Constants { uint first; uint last; };

#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/pair.glsl"
#include "common/shade.glsl"
#include "common/store.glsl"

struct Sums {
    vec3 light;      // Σ w·c·L
    vec3 known;      // Σ w·c
    vec2 shares;     // Σ w·c and Σ w as luminances
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

void add(inout Sums sums, Pixel p, Tap tap, bool across) {
    Hit h = unpack_hit(tap.word);
    vec3 l = h.direction;
    float pdf = h.pdf;
    if (h.status == HIT) {
        vec3 to_hit = tap.from + h.direction * h.distance - p.position;
        l = normalize_or(to_hit, l);
        // Between the eyes the reflecting points lie further apart than between neighbours: the density over solid
        // angle changes with the distance to what both see.
        if (across && !is_mirror(p.surface)) {
            pdf *= clamp(dot(to_hit, to_hit) / max(square(h.distance), 1e-12), 0.25, 4.0);
        }
    }
    vec3 w = reflection_weight(p.surface, p.v, l, pdf);
    // Below the triangle's horizon a direction is known to be black, as in the reference.
    bool open = dot(l, p.surface.face_normal) > 0.0;
    vec3 radiance = vec3(0.0);
    if (h.status == HIT && open) {
        ivec2 at = min(ivec2(h.uv * vec2(frame.size)), ivec2(frame.size) - 1);
        radiance = texelFetch(radiance_image, ivec3(at, h.eye), 0).rgb;
    } else if (h.status == SKY && open) {
        radiance = environment_radiance(h.direction);
    }
    if (frame.firefly != 0u) w /= 1.0 + luminance(radiance);
    sums.light += w * h.confidence * radiance;
    sums.known += w * h.confidence;
    sums.shares += luminance(w) * vec2(h.confidence, 1.0);
}

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    Pixel p = load_pixel(texel);
    bool mirror = is_mirror(p.surface);
    int radius = mirror ? 0 : int(RADIUS);
    ivec3 pair = ivec3(0);
    bool paired = REPROJECT != 0u && find_pair(p, pair);

    EyeRays own_rays = eye_rays(uint(texel.z)), other_rays = own_rays;
    if (paired) other_rays = eye_rays(uint(pair.z));
    Sums sums = Sums(vec3(0.0), vec3(0.0), vec2(0.0));
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            if (paired && (x + y & 1) != 0) continue;
            Tap own = load_tap(p, texel + ivec3(x, y, 0), own_rays);
            if (paired) {
                Tap other = load_tap(p, pair + ivec3(x, y, 0), other_rays);
                // What one eye knows fills what the other does not. A mirror needs no more than that.
                if (other.usable && own.usable) {
                    if (known(other.word) && !known(own.word)) own.usable = false;
                    else if (mirror || known(own.word) && !known(other.word)) other.usable = false;
                }
                if (other.usable) add(sums, p, other, true);
            }
            if (own.usable) add(sums, p, own, false);
        }
    }
    if (SUMS != 0u) {
        if (first == 0u) {
            vec4 earlier_sum = imageLoad(sum_image, texel), earlier_weight = imageLoad(weight_image, texel);
            sums.light += earlier_sum.rgb;
            sums.known += earlier_weight.rgb;
            sums.shares += vec2(earlier_sum.a, earlier_weight.a);
        }
        imageStore(sum_image, texel, vec4(sums.light, sums.shares.x));
        imageStore(weight_image, texel, vec4(sums.known, sums.shares.y));
        if (last == 0u) return;
    }
    float confidence = sums.shares.y > 0.0 ? sums.shares.x / sums.shares.y : 0.0;
    // Where a channel has hardly any weight, the ratio of luminances is the steadier one.
    vec3 steady = vec3(luminance(sums.light) / max(luminance(sums.known), 1e-12));
    vec3 ratio = mix(sums.light / max(sums.known, vec3(1e-6)), steady, lessThan(sums.known, vec3(1e-6)));
    if (sums.shares.x <= 0.0) ratio = vec3(0.0);
    float nv = max(dot(p.surface.normal, p.v), 1e-4);
    vec3 fallback = vec3(0.0);
    if (frame.fallback != 0u) fallback = environment_specular(reflect(-p.v, p.surface.normal), p.surface.roughness);
    vec3 radiance = mix(fallback, ratio, confidence) * specular_albedo(p.surface.f0, nv, p.surface.roughness);
    imageStore(reflection_image, texel, vec4(storable(radiance), confidence));
}
