#version 460
// In: each eye's filtered reflection (or its history, from accumulate.comp). Out: the outgoing reflection, blended with that of
// the other eye.
// The paper's §4.3: the virtual image of what a pixel reflects leads to the other eye's pixel that reflects the same thing,
// and "we can directly reuse the illumination result". It is reused after the filter: then the pair's 25 taps cost one fetch,
// and two pixels that are each other's pair get the same light, with the same noise.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;
// The next three are 1 in our reprojection and 0 in the publication's: see `Reprojection` in src/method/parts.rs.
layout(constant_id = 0) const uint FILLING = 1u;
layout(constant_id = 1) const uint BACK_CHECK = 1u;
layout(constant_id = 2) const uint LOBE_TOLERANCE = 1u;
// 1: the eyes are blended by squared bias and both variances (seed 003, equation 4: Philippi et al. 2023); 0: by the weights
// of their taps, as in the publication and with the ratio estimator.
layout(constant_id = 3) const uint BY_VARIANCE = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform usampler2DArray guide_image;
// The known share of the light, C·L, and C.
layout(binding = 6) uniform sampler2DArray known_image;
// x: Σ w of the taps; y, the nearness: mean of 1/(distance from the eye by way of the surface to what is reflected), 1/m, to
// which disparity is proportional; 0: unknown; z: variance of the known light's luminance.
layout(binding = 7) uniform sampler2DArray standing_image;
layout(binding = 8) uniform sampler2D environment_map;
layout(binding = 9) uniform sampler2D irradiance_map;
layout(binding = 10) uniform sampler2D specular_map;
layout(binding = 11) uniform sampler2D brdf_table;
layout(binding = 12, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 13, rgba16f) writeonly uniform image2DArray reflection_image;

#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/shade.glsl"
#include "common/outgoing.glsl"
#include "common/store.glsl"

// The largest relative difference that the publication allows between the depths of two reflections.
const float FIXED_TOLERANCE = 0.001;

struct Known {
    vec4 light;      // C·L, C
    float weight;    // Σ w
    float nearness;
    float variance;  // of the luminance of L
};

Known load_known(ivec3 texel) {
    vec3 standing = texelFetch(standing_image, texel, 0).xyz;
    return Known(texelFetch(known_image, texel, 0), standing.x, standing.y, standing.z);
}

// From the surface to what it reflects, metres.
float hit_distance(float nearness, float eye_distance) { return max(1.0 / nearness - eye_distance, 0.0); }

// Whether the other eye's pixel is p's pair: its surface, what it reflects and the reprojection back to p must all agree.
// aim: the distance of the reflection with which the pixel was found; tolerance: of the reprojection back, pixels.
bool agrees(Pixel p, float aim, vec2 pixel, float tolerance, out Known q_known) {
    ivec3 at = ivec3(ivec2(pixel), 1 - p.texel.z);
    Guide g = load_guide(at);
    if (g.instance == 0u) return false;
    Pixel q = p;
    q.texel = at;
    q.position = render_position(uint(at.z), vec2(at.xy) + 0.5, g.depth);
    if (!same_surface(p, g, q.position)) return false;
    q_known = load_known(at);
    if (q_known.light.a <= 0.0) return false;
    vec3 to_eye = eye_position(uint(at.z)) - q.position;
    float q_eye_distance = length(to_eye);
    q.v = to_eye / q_eye_distance;
    q.surface.normal = unpack_direction(g.normal);
    float back_distance = hit_distance(q_known.nearness, q_eye_distance);
    if (LOBE_TOLERANCE == 0u) {
        // The depths of both virtual images in the view of p's eye.
        mat4 view = frame.eyes[p.texel.z].view_from_render;
        float mine = (view * vec4(p.position - p.v * aim, 1.0)).z;
        float theirs = (view * vec4(q.position - q.v * back_distance, 1.0)).z;
        if (abs(theirs - mine) > FIXED_TOLERANCE * abs(mine)) return false;
    }
    if (BACK_CHECK == 0u) return true;
    vec2 back;
    return image_in(q, uint(p.texel.z), back_distance, back) && distance(back, vec2(p.texel.xy) + 0.5) <= tolerance;
}

// Finds a pixel's pair at the place of the virtual image, or else at the place of the surface itself, where the lobe is wide
// enough to cover the distance between the two. lobe: half the lobe's width, pixels.
bool find_pair(Pixel p, Known own, float eye_distance, out Known pair, out float lobe) {
    uint other = 1u - uint(p.texel.z);
    pair = Known(vec4(0.0), 0.0, 0.0, 0.0);
    lobe = 0.0;
    float aim = 0.0;
    vec2 surface_pixel, image_pixel;
    if (own.light.a <= 0.0) {
        // The pixel knows no distance itself, but the other eye may know it at the same place of the surface.
        if (FILLING == 0u || !image_in(p, other, 0.0, surface_pixel)) return false;
        ivec3 there = ivec3(ivec2(surface_pixel), other);
        Guide g = load_guide(there);
        vec3 position = render_position(other, vec2(there.xy) + 0.5, g.depth);
        if (g.instance == 0u || !same_surface(p, g, position)) return false;
        float nearness = load_known(there).nearness;
        if (nearness <= 0.0) return false;
        aim = hit_distance(nearness, distance(eye_position(other), position));
    } else {
        if (own.nearness <= 0.0) return false;
        aim = hit_distance(own.nearness, eye_distance);
    }
    lobe = lobe_pixels(p, aim);
    // The lobe's footprint, plus half a pixel for rounding to pixels.
    float tolerance = max(1.0, lobe) + 0.5;
    bool image_seen = image_in(p, other, aim, image_pixel);
    if (image_seen && agrees(p, aim, image_pixel, tolerance, pair)) return true;
    if (LOBE_TOLERANCE == 0u || is_mirror(p.surface) || !image_seen) return false;
    if (!image_in(p, other, 0.0, surface_pixel)) return false;
    return distance(surface_pixel, image_pixel) <= lobe &&
           agrees(p, 0.0, surface_pixel, tolerance, pair);
}

// The share of the pair's light in a pixel, 0–1: β = σ_Y²/((E[X] − E[Y])² + σ_X² + σ_Y²), where Y is the pixel's own light.
// Both eyes sample the same reflection, so that a tap has the same variance in both. The sum of both variances is therefore
// divided between σ_X² and σ_Y² by the weights of the taps. Each eye's separate estimate would grow with its own brightness,
// and would prefer the darker eye.
// The difference of the estimates contains the noise of both. Only what exceeds four of its standard errors counts as bias, so
// that eyes that differ by chance alone get the same mean.
float share_by_variance(Known own, Known pair, float own_weight, float pair_weight) {
    float difference = luminance(pair.light.rgb) / pair.light.a - luminance(own.light.rgb) / own.light.a;
    float noise = own.variance + pair.variance;
    float bias2 = max(square(difference) - 16.0 * noise, 0.0);
    return pair_weight / (own_weight + pair_weight) * noise / max(bias2 + noise, 1e-20);
}

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    Pixel p = load_pixel(texel);
    float eye_distance = distance(eye_position(uint(texel.z)), p.position);
    Known own = load_known(texel), pair;
    float lobe;
    vec4 light = own.light;
    if (find_pair(p, own, eye_distance, pair, lobe)) {
        // The pair is up to half a pixel off, which would blur the sharp reflection of a narrow lobe, and a narrow lobe has no
        // noise to reduce. There, as in a mirror, the pair only fills gaps.
        float share = is_mirror(p.surface) ? 0.0 : clamp(lobe, 0.0, 1.0);
        float own_weight = own.weight, pair_weight = pair.weight;
        if (FILLING != 0u) {
            // Where both eyes know about the same share of the light, they differ by chance, and their mean is right. Where one
            // eye knows much more, the other cannot see what is reflected, and the weights follow what each eye knows.
            float blind = smoothstep(0.2, 0.6, abs(own.light.a - pair.light.a));
            own_weight *= mix(1.0, own.light.a, blind);
            pair_weight *= mix(1.0, pair.light.a, blind);
        }
        if (own.light.a > 0.0) pair_weight *= share;
        if (BY_VARIANCE != 0u && own.light.a > 0.0 && own_weight + pair_weight > 0.0) {
            // The known share of the light is weighted by the taps; its brightness by the variances.
            float known = (own_weight * own.light.a + pair_weight * pair.light.a) / (own_weight + pair_weight);
            vec3 mine = own.light.rgb / own.light.a, theirs = pair.light.rgb / pair.light.a;
            float own_taps = own_weight * own.light.a, pair_taps = pair_weight * pair.light.a;
            light = vec4(mix(mine, theirs, share_by_variance(own, pair, own_taps, pair_taps)) * known, known);
        } else {
            light = (own_weight * own.light + pair_weight * pair.light) / max(own_weight + pair_weight, 1e-12);
        }
    }
    imageStore(reflection_image, texel, vec4(storable(outgoing(p, light.rgb, light.a)), light.a));
}
