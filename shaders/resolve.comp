#version 460
// In: hits, radiance, G-buffer. Out: the outgoing reflection of each listed pixel, with the share of it that is known in alpha.
// Spatial reuse over 5×5 pixels as a ratio estimator with the BRDF in it (Stachowiak 2015):
// L = Σ w_i·L_i / Σ w_i per channel, times the lobe's albedo F0·A + B. A tap's weight w_i is
// - with BALANCE 0: f·cos/p_i, as published. It is unbounded where the pixel's lobe is high and the tap's density is low.
// - with BALANCE 1: f·cos times the balance heuristic between the tap's density and the pixel's own (pairwise, Bitterli 2022,
//   §5.4.2). It is at most a constant times f·cos/p of the pixel's own sampling, which is at most about 1.
// The fallback stands in for unknown rays: C·L + (1 − C)·fallback with C = Σ w·c/Σ w.
// With FOR_PAIRS a later pass blends in the other eye (reproject.comp) or earlier frames (accumulate.comp). The output is then
// the known share of the light, C·L and C, its weight, the nearness of what is reflected, and with MOMENTS the variance of the
// estimate.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;
// Squared radius of the neighbourhood, pixels². 0: only the pixel's own sample (a study's "no reuse"); 8: the paper's 5×5.
layout(constant_id = 0) const uint RADIUS_SQUARED = 8u;
// 1: a pixel has several samples, which several dispatches sum into one ratio.
layout(constant_id = 1) const uint SUMS = 0u;
layout(constant_id = 2) const uint FOR_PAIRS = 0u;
// 1: the right eye traces no rays, and its output is 0.
layout(constant_id = 3) const uint ONE_EYE = 0u;
// 1: the radiance of every hit lies in ray_radiance_image, at the ray's own pixel; 0: it is that of the pixel that was hit.
layout(constant_id = 4) const uint OWN_RADIANCE = 0u;
layout(constant_id = 5) const uint BALANCE = 1u;
// 1: lost rays have asked the geometry; confidences are relative weights (lost.glsl) and nothing is unknown.
layout(constant_id = 6) const uint HYBRID = 0u;
layout(constant_id = 7) const uint MOMENTS = 0u;
// 1: only pixels whose eyes may differ visibly are left to reproject.comp; the others are finished here.
layout(constant_id = 8) const uint ADAPTIVE = 0u;
// (2·radius + 1)².
layout(constant_id = 9) const uint MOST_TAPS = 25u;

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
// x: Σ w; y: the nearness, see reproject.comp; z: variance of the known light's luminance; w: 1 where the pixel is finished.
// Between the samples of a pixel: Σ a², the sum for y, Σ x², Σ x·a of the taps' light x and weight a.
layout(binding = 16, rgba32f) uniform image2DArray standing_image;
// The radiance of hits in the scene's geometry, at the ray's own pixel.
layout(binding = 17) uniform sampler2DArray ray_radiance_image;
// With ADAPTIVE: the outgoing reflection of the pixels that are finished here.
layout(binding = 18, rgba16f) writeonly uniform image2DArray finished_image;
layout(push_constant) uniform Constants { uint first; uint last; float weber; };

#include "common/ray_list.glsl"
#include "common/hit.glsl"
#include "common/reflect.glsl"
#include "common/lobe.glsl"
#include "common/shade.glsl"
#include "common/outgoing.glsl"
#include "common/store.glsl"

// Bounds on what one tap may contribute, against fireflies. A tap may contribute ALWAYS_DISPLAYED of display white (more with
// few taps, up to all of display white with a single one), plus the larger of two amounts: the share MOST_SHARE of the pixel's
// light, and ALWAYS_BRIGHTNESS times the mean of the other taps.
const float MOST_SHARE = 0.2;
const float ALWAYS_BRIGHTNESS = 2.0;
const float ALWAYS_DISPLAYED = 0.02;

// The distance of the sky, metres: so far that it has no disparity between the eyes.
const float SKY_DISTANCE = 1e9;

// The number of neighbours that the balance heuristic assumes: the pixel's own sample is one of 25.
const float NEIGHBOURS = 24.0;

struct Sums {
    vec3 light;      // Σ w·c·L
    vec3 known;      // Σ w·c
    vec2 shares;     // Σ w·c and Σ w as luminances
    float nearness;  // Σ w·c/(distance from the eye by way of the surface to the hit)
};

// The luminances of w·c·L and of w·c for each tap.
float tap_light[MOST_TAPS];
float tap_weight[MOST_TAPS];
int taps = 0;

vec3 tap_radiance(Hit h, ivec3 texel) {
    if (OWN_RADIANCE != 0u) return texelFetch(ray_radiance_image, texel, 0).rgb;
    if (HYBRID != 0u && h.status == SHADED) return texelFetch(ray_radiance_image, texel, 0).rgb;
    if (h.status == SKY) return environment_radiance(h.direction);
    ivec2 at = min(ivec2(h.uv * vec2(frame.size)), ivec2(frame.size) - 1);
    return texelFetch(radiance_image, ivec3(at, h.eye), 0).rgb;
}

bool is_place(uint status) { return status == HIT || HYBRID != 0u && status == SHADED; }

// The direction from a pixel's position to the hit of a tap's ray, and the distance to it.
vec3 towards(Hit h, vec3 from, vec3 position, out float far) {
    vec3 l = h.direction;
    far = BALANCE != 0u ? SKY_DISTANCE : frame.ray_length;
    if (is_place(h.status)) {
        vec3 to_hit = from + h.direction * h.distance - position;
        far = length(to_hit);
        l = far > 0.0 ? to_hit / far : l;
    }
    return l;
}

void accumulate(inout Sums sums, Pixel p, float eye_distance, Hit h, vec3 w, vec3 l, float far, ivec3 texel) {
    // Directions below the triangle's horizon count as black, as in the reference.
    bool open = dot(l, p.surface.face_normal) > 0.0;
    vec3 radiance = vec3(0.0);
    if (open && (is_place(h.status) || h.status == SKY)) radiance = tap_radiance(h, texel);
    if (frame.firefly == 1u) w /= 1.0 + luminance(radiance);
    float share = luminance(w);
    vec3 light = w * h.confidence * radiance;
    sums.light += light;
    sums.known += w * h.confidence;
    sums.shares += share * vec2(h.confidence, 1.0);
    if (FOR_PAIRS != 0u) sums.nearness += share * h.confidence / (eye_distance + far);
    if ((frame.firefly == 2u || MOMENTS != 0u) && taps < int(MOST_TAPS)) {
        tap_light[taps] = luminance(light);
        tap_weight[taps] = share * h.confidence;
        ++taps;
    }
}

// f·cos towards l, and the density with which the pixel's own lobe samples l.
vec3 evaluate(Pixel p, Lobe lobe, vec3 l, out float density) {
    vec3 h;
    float d = lobe_distribution(lobe, l, h);
    density = d * lobe.scale;
    float nv = dot(lobe.n, lobe.v), nl = dot(lobe.n, l);
    if (nl <= 0.0 || nv <= 0.0) return vec3(0.0);
    float vh = dot(lobe.v, h) * inversesqrt(max(dot(h, h), 1e-30));
    return d * smith_visibility(nv, nl, square(p.surface.roughness)) * nl * schlick(p.surface.f0, vh);
}

// Converts a tap's density, which is over solid angle at the start of its ray, into a density over solid angle at p: the ratio
// of the squared distances. The cosine at the hit is left out, because it is nearly the same for both.
float jacobian(Hit h, float far, float tap_far) {
    return is_place(h.status) ? clamp(square(far / max(tap_far, 1e-9)), 1.0 / 64.0, 64.0) : 1.0;
}

// Spatial reuse with the published weights (BALANCE 0).
void gather_ratio(inout Sums sums, Pixel p, float eye_distance, int reach, int radius) {
    EyeRays rays_of_eye = eye_rays(uint(p.texel.z));
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            if (x * x + y * y > reach) continue;
            ivec3 texel = p.texel + ivec3(x, y, 0);
            vec3 from = p.position;
            if (texel != p.texel) {
                if (any(lessThan(texel.xy, ivec2(0))) || any(greaterThanEqual(texel.xy, ivec2(frame.size)))) continue;
                Guide g = load_guide(texel);
                from = position_along(rays_of_eye, vec2(texel.xy) + 0.5, g.depth);
                if (!same_surface(p, g, from)) continue;
            }
            uvec4 word = texelFetch(hit_image, texel, 0);
            if (!contributes(word)) continue;
            Hit h = unpack_hit(word);
            float far;
            vec3 l = towards(h, from, p.position, far);
            accumulate(sums, p, eye_distance, h, reflection_weight(p.surface, p.v, l, h.pdf), l, far, texel);
        }
    }
}

// Spatial reuse with multiple-importance weights (BALANCE 1). Let p_c be the pixel's own density, p_i a tap's, both over solid
// angle at p, and K the number of neighbours. Up to a common factor, a tap weighs f·cos/(p_i + p_c/K), and the pixel's own
// sample f·cos·Σ_i 1/(K·p_i + p_c). In each pair of a tap and the own sample the weights add up to one for every direction, so
// that the mean over the pairs is unbiased.
void gather_balance(inout Sums sums, Pixel p, float eye_distance, int reach, int radius) {
    EyeRays rays_of_eye = eye_rays(uint(p.texel.z));
    Lobe lobe = make_lobe(p.surface.normal, p.v, p.surface.roughness);
    uvec4 own_word = texelFetch(hit_image, p.texel, 0);
    Hit own = unpack_hit(own_word);
    bool has_own = contributes(own_word);
    float own_far, own_density;
    vec3 own_l = towards(own, p.position, p.position, own_far);
    vec3 own_f = evaluate(p, lobe, own_l, own_density);
    vec3 own_place = p.position + own.direction * own.distance;
    float own_sum = 0.0;
    int neighbours = 0;
    for (int y = -radius; y <= radius; ++y) {
        for (int x = -radius; x <= radius; ++x) {
            if (x * x + y * y > reach || x == 0 && y == 0) continue;
            ivec3 texel = p.texel + ivec3(x, y, 0);
            if (any(lessThan(texel.xy, ivec2(0))) || any(greaterThanEqual(texel.xy, ivec2(frame.size)))) continue;
            Guide g = load_guide(texel);
            vec3 from = position_along(rays_of_eye, vec2(texel.xy) + 0.5, g.depth);
            if (!same_surface(p, g, from)) continue;
            ++neighbours;
            if (has_own) {
                Lobe its = make_lobe(unpack_direction(g.normal), normalize(rays_of_eye.origin - from), g.roughness);
                vec3 to_place = own_place - from;
                float its_far = length(to_place);
                bool place = is_place(own.status);
                float its_density = lobe_density(its, place ? to_place / max(its_far, 1e-9) : own_l);
                own_sum += 1.0 / (NEIGHBOURS * its_density * jacobian(own, own_far, its_far) + own_density);
            }
            uvec4 word = texelFetch(hit_image, texel, 0);
            if (!contributes(word)) continue;
            Hit h = unpack_hit(word);
            float far, density;
            vec3 l = towards(h, from, p.position, far);
            vec3 f = evaluate(p, lobe, l, density);
            float both = h.pdf * jacobian(h, far, h.distance) + density * (1.0 / NEIGHBOURS);
            accumulate(sums, p, eye_distance, h, f / max(both, 1e-20), l, far, texel);
        }
    }
    if (!has_own) return;
    vec3 w = neighbours > 0 ? own_f * own_sum : own_f / max(own_density, 1e-20);
    accumulate(sums, p, eye_distance, own, w, own_l, own_far, p.texel);
}

// The most that tap i may contribute where all taps together contribute `total`. All are luminances of w·c·L.
float most_of(int i, float always, float total, float all_weight) {
    float others = max(total - tap_light[i], 0.0) / max(all_weight - tap_weight[i], 1e-12);
    return always + max(MOST_SHARE * total, ALWAYS_BRIGHTNESS * tap_weight[i] * others);
}

// Lowers every tap that exceeds its bound, which depends on the sum of all taps. The result is the largest fixed point of the
// map from the light to the sum of the lowered taps; the iteration starts above it, at the sum of the unbounded taps. Returns
// the factor for the light. earlier: Σ w·c·L and Σ w·c of the pixel's earlier samples, luminances.
float bound_taps(float display_scale, float light, float weight, vec2 earlier) {
    if (light <= 0.0) return 1.0;
    float all_weight = earlier.y + weight;
    float displayed = max(ALWAYS_DISPLAYED, 1.0 / square(float(taps)));
    float always = all_weight * displayed / max(display_scale, 1e-6);
    float bounded = light;
    for (int pass = 0; pass < 12; ++pass) {
        float sum = 0.0;
        for (int i = 0; i < taps; ++i) {
            tap_light[i] = min(tap_light[i], most_of(i, always, earlier.x + bounded, all_weight));
            sum += tap_light[i];
        }
        if (sum >= bounded * 0.99) break;
        bounded = sum;
    }
    return bounded / light;
}

// Σ x², Σ x·a, Σ a² of the taps' light x and weight a.
vec3 tap_moments() {
    vec3 m = vec3(0.0);
    for (int i = 0; i < taps; ++i) m += vec3(square(tap_light[i]), tap_light[i] * tap_weight[i], square(tap_weight[i]));
    return m;
}

void resolve(ivec3 texel) {
    if (ONE_EYE != 0u && texel.z == 1) {
        imageStore(reflection_image, texel, vec4(0.0));
        imageStore(standing_image, texel, vec4(0.0));
        return;
    }
    Pixel p = load_pixel(texel);
    bool mirror = is_mirror(p.surface);
    // A mirror reflects a single direction, which no neighbour shares.
    int reach = mirror ? 0 : int(RADIUS_SQUARED);
    int radius = int(sqrt(float(reach) + 0.5));
    float eye_distance = FOR_PAIRS != 0u ? distance(eye_position(uint(texel.z)), p.position) : 0.0;
    Sums sums = Sums(vec3(0.0), vec3(0.0), vec2(0.0), 0.0);
    if (BALANCE != 0u && !mirror) gather_balance(sums, p, eye_distance, reach, radius);
    else gather_ratio(sums, p, eye_distance, reach, radius);

    vec4 earlier_sum = vec4(0.0), earlier_weight = vec4(0.0), earlier_standing = vec4(0.0);
    if (SUMS != 0u && first == 0u) {
        earlier_sum = imageLoad(sum_image, texel);
        earlier_weight = imageLoad(weight_image, texel);
        if (FOR_PAIRS != 0u) earlier_standing = imageLoad(standing_image, texel);
    }
    float albedo = 0.0;
    if (frame.firefly == 2u || ADAPTIVE != 0u) {
        float nv = max(dot(p.surface.normal, p.v), 1e-4);
        albedo = luminance(specular_albedo(p.surface.f0, nv, p.surface.roughness));
    }
    if (frame.firefly == 2u && !mirror) {
        vec2 earlier = vec2(luminance(earlier_sum.rgb), earlier_sum.a);
        sums.light *= bound_taps(albedo * frame.exposure, luminance(sums.light), sums.shares.x, earlier);
    }
    vec3 moments = vec3(0.0);
    if (MOMENTS != 0u) moments = tap_moments() + earlier_standing.zwx;
    if (SUMS != 0u) {
        if (first == 0u) {
            sums.light += earlier_sum.rgb;
            sums.known += earlier_weight.rgb;
            sums.shares += vec2(earlier_sum.a, earlier_weight.a);
            sums.nearness += earlier_standing.y;
        }
        imageStore(sum_image, texel, vec4(sums.light, sums.shares.x));
        imageStore(weight_image, texel, vec4(sums.known, sums.shares.y));
        if (last == 0u) {
            if (FOR_PAIRS != 0u) imageStore(standing_image, texel, vec4(moments.z, sums.nearness, moments.xy));
            return;
        }
    }
    float confidence = sums.shares.y > 0.0 ? sums.shares.x / sums.shares.y : 0.0;
    // Where a channel has hardly any weight, the ratio of the luminances is more stable.
    vec3 steady = vec3(luminance(sums.light) / max(luminance(sums.known), 1e-12));
    vec3 ratio = mix(sums.light / max(sums.known, vec3(1e-6)), steady, lessThan(sums.known, vec3(1e-6)));
    if (sums.shares.x <= 0.0) ratio = vec3(0.0);
    if (HYBRID != 0u) confidence = sums.shares.x > 0.0 ? 1.0 : 0.0;
    vec3 light = ratio * confidence;
    float variance = 0.0;
    if (MOMENTS != 0u && sums.shares.x > 0.0) {
        // The variance of a weighted mean, from the taps' spread about it. With hardly more than one effective tap the spread
        // says nothing. From four effective taps down to one, the standard error is therefore raised towards the mean itself.
        float mean = luminance(ratio), one_over_taps = moments.z / square(sums.shares.x);
        float spread = max(moments.x - 2.0 * mean * moments.y + mean * mean * moments.z, 0.0) / square(sums.shares.x);
        variance = spread / max(1.0 - one_over_taps, 0.25) + mean * mean * max(one_over_taps - 0.25, 0.0);
    }
    bool finished = false;
    if (ADAPTIVE != 0u && confidence > 0.0) {
        // How far the eyes may differ: the standard error of their difference, plus what only the other eye may know.
        float apart = albedo * (sqrt(2.0 * variance) + (1.0 - confidence) * luminance(ratio));
        float shown = albedo * luminance(light) + luminance(texelFetch(radiance_image, texel, 0).rgb);
        finished = apart <= weber * shown;
        if (finished) imageStore(finished_image, texel, vec4(storable(outgoing(p, light, confidence)), confidence));
    }
    if (FOR_PAIRS == 0u) light = outgoing(p, light, confidence);
    imageStore(reflection_image, texel, vec4(storable(light), confidence));
    float nearness = sums.shares.x > 0.0 ? sums.nearness / sums.shares.x : 0.0;
    if (FOR_PAIRS != 0u) imageStore(standing_image, texel, vec4(sums.shares.y, nearness, variance, finished ? 1.0 : 0.0));
}

void main() {
    ivec3 texel;
    if (listed_pixel(texel)) resolve(texel);
}
