#version 460
// In: hits, radiance, G-buffer. Out: the outgoing reflection of each listed pixel; alpha = how much of it is known.
// Spatial reuse over 5×5 pixels as a ratio estimator with the BRDF in it (Stachowiak 2015):
// L = Σ w_i·L_i / Σ w_i per channel, times the lobe's own albedo F0·A + B. A tap's weight w_i is
// - RATIO: f·cos/p_i, the published one. It has no bound where the pixel's lobe is high and the tap's density is low.
// - BALANCE: f·cos times the balance heuristic between the tap's density and the pixel's own (pairwise, Bitterli 2022,
//   §5.4.2). It is at most a constant times f·cos/p of the pixel's own sampling, which is at most about 1.
// Unknown rays take the fallback's share: C·L + (1 − C)·fallback with C = Σ w·c/Σ w.
// With FOR_PAIRS the other eye (reproject.comp) or the frames before (accumulate.comp) have a say: out go the known share of the light, C·L and C, what it
// weighs, how far away the pixel's reflection stands, and with MOMENTS the variance of the estimate.
// Reference: never.
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
layout(constant_id = 5) const uint BALANCE = 1u;
// 1: the geometry answers what the views lose; confidences are relative weights (lost.glsl) and nothing is unknown.
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
// x: Σ w; y: see reproject.comp; z: variance of the known light's luminance; w: 1 where the pixel is finished. Between the
// samples of a pixel Σ a², the sum of y, Σ x², Σ x·a of the taps' light x and weight a.
layout(binding = 16, rgba32f) uniform image2DArray standing_image;
// Radiance of rays that brought their own, at their own pixel.
layout(binding = 17) uniform sampler2DArray ray_radiance_image;
// With ADAPTIVE: the reflection of pixels that are finished here.
layout(binding = 18, rgba16f) writeonly uniform image2DArray finished_image;
layout(push_constant) uniform Constants { uint first; uint last; float weber; };

#include "common/ray_list.glsl"
#include "common/hit.glsl"
#include "common/reflect.glsl"
#include "common/lobe.glsl"
#include "common/shade.glsl"
#include "common/outgoing.glsl"
#include "common/store.glsl"

// Against fireflies no tap may bring more than this share of the pixel's light, unless it is at most so many times as
// bright as the other taps' mean, on top of what it may always bring: a share of display white. With few taps to judge by
// it may bring more: all of display white where there is one tap.
const float MOST_SHARE = 0.2;
const float ALWAYS_BRIGHTNESS = 2.0;
const float ALWAYS_DISPLAYED = 0.02;

// How far away the sky stands, metres: so far that no two eyes differ in it, whatever else the scene holds.
const float SKY_DISTANCE = 1e9;

// How the balance heuristic counts a pixel's own sample against each neighbour's: one of 25.
const float NEIGHBOURS = 24.0;

struct Sums {
    vec3 light;      // Σ w·c·L
    vec3 known;      // Σ w·c
    vec2 shares;     // Σ w·c and Σ w as luminances
    float nearness;  // Σ w·c/(distance along the ray from the eye over the surface to what it hit)
};

// Luminances of w·c·L and w·c of the taps.
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

// Direction from a pixel's position to what a tap's ray hit, and how far that is.
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
    // Below the triangle's horizon a direction is known to be black, as in the reference.
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

// f·cos, and the density of the lobe's own sampling towards l.
vec3 evaluate(Pixel p, Lobe lobe, vec3 l, out float density) {
    vec3 h;
    float d = lobe_distribution(lobe, l, h);
    density = d * lobe.scale;
    float nv = dot(lobe.n, lobe.v), nl = dot(lobe.n, l);
    if (nl <= 0.0 || nv <= 0.0) return vec3(0.0);
    float vh = dot(lobe.v, h) * inversesqrt(max(dot(h, h), 1e-30));
    return d * smith_visibility(nv, nl, square(p.surface.roughness)) * nl * schlick(p.surface.f0, vh);
}

// Area at the hit, seen from where its ray starts, over the same seen from p: turns the tap's density into one about p.
// The cosine at the hit, nearly the same from both, is left out.
float jacobian(Hit h, float far, float tap_far) {
    return is_place(h.status) ? clamp(square(far / max(tap_far, 1e-9)), 1.0 / 64.0, 64.0) : 1.0;
}

// The published weights.
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

// Multiple-importance weights. With p_c the pixel's own density and p_i a tap's, both about p, and K neighbours, a tap
// weighs f·cos/(p_i + p_c/K) and the own sample f·cos·Σ_i 1/(K·p_i + p_c), up to one common factor: each pair's weights
// add up to one for every direction, so that the mean over pairs is unbiased.
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

// The most that tap i may bring where all taps together bring `total`; luminances of Σ w·c·L.
float most_of(int i, float always, float total, float all_weight) {
    float others = max(total - tap_light[i], 0.0) / max(all_weight - tap_weight[i], 1e-12);
    return always + max(MOST_SHARE * total, ALWAYS_BRIGHTNESS * tap_weight[i] * others);
}

// No tap may bring more than its share of the pixel's light: where one does, it is lowered until it does not. The
// largest such light is the fixed point of the map from the light to the sum of the lowered taps, and the sum of all
// taps lies above it. Returns the factor for the light. earlier: Σ w·c·L and Σ w·c of the earlier samples, luminances.
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
    // A mirror's one direction is its own.
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
    // Where a channel has hardly any weight, the ratio of luminances is the steadier one.
    vec3 steady = vec3(luminance(sums.light) / max(luminance(sums.known), 1e-12));
    vec3 ratio = mix(sums.light / max(sums.known, vec3(1e-6)), steady, lessThan(sums.known, vec3(1e-6)));
    if (sums.shares.x <= 0.0) ratio = vec3(0.0);
    if (HYBRID != 0u) confidence = sums.shares.x > 0.0 ? 1.0 : 0.0;
    vec3 light = ratio * confidence;
    float variance = 0.0;
    if (MOMENTS != 0u && sums.shares.x > 0.0) {
        // Of a weighted mean, from the taps' spread about it. Where hardly more than one tap counts, the spread says
        // nothing: from four effective taps down to one, the mean becomes as uncertain as it is large.
        float mean = luminance(ratio), one_over_taps = moments.z / square(sums.shares.x);
        float spread = max(moments.x - 2.0 * mean * moments.y + mean * mean * moments.z, 0.0) / square(sums.shares.x);
        variance = spread / max(1.0 - one_over_taps, 0.25) + mean * mean * max(one_over_taps - 0.25, 0.0);
    }
    bool finished = false;
    if (ADAPTIVE != 0u && confidence > 0.0) {
        // How far the eyes may differ: the standard error of a difference, and what the other eye may know beyond.
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
