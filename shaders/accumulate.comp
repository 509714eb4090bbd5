#version 460
// In: each eye's filtered reflection of this frame, and the history, which is the accumulated reflection of earlier frames.
// Out: the new history, for the next frame and for reproject.comp; with FINISH the outgoing reflection.
// The history is looked up in two places (seed 002): where the surface was in the last frame, and where the last frame's eye
// saw the virtual image of what the surface reflects. The history that fits this frame better is used.
// The weight of this frame against the history follows from bias and variances (seed 003, equation 4: Philippi et al. 2023).
// The history carries its effective number of frames (equation 5), so that a still view converges to the mean of its frames.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
// The weight of a new frame. 0: by bias and variance; 1: one tenth; 2: one tenth, and the history is clamped to the
// neighbourhood.
layout(constant_id = 0) const uint WEIGHTS = 0u;
// Where the history is looked up. 0: in both places, and the better one is used; 1: at the surface's last place; 2: at the
// virtual image's last place, and at the surface's only where this frame does not know the distance.
layout(constant_id = 1) const uint SOURCE = 0u;
// 1: some object of the scene moves.
layout(constant_id = 2) const uint MOVES = 0u;
// 1: reproject.comp does not run after this pass, which therefore writes the outgoing reflection.
layout(constant_id = 3) const uint FINISH = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std140) uniform LastFrames { FrameUniform last; };
layout(binding = 2, std430) buffer Counters { CountersData counters; };
layout(binding = 3) uniform usampler2DArray surface_image;
layout(binding = 4) uniform usampler2DArray guide_image;
// As resolve.comp writes them with FOR_PAIRS: C·L and C; Σ w, nearness, variance of L.
layout(binding = 5) uniform sampler2DArray known_image;
layout(binding = 6) uniform sampler2DArray standing_image;
// The history, image by image: the guide of its frame; C·L and C; Σ w, nearness, variance of L, effective number of frames;
// the variance of L of a single frame, and the running mean of how far the last frames lay above the history.
layout(binding = 7) uniform usampler2DArray last_guide_image;
layout(binding = 8) uniform sampler2DArray last_known_image;
layout(binding = 9) uniform sampler2DArray last_standing_image;
layout(binding = 10) uniform sampler2DArray last_trend_image;
layout(binding = 11, rgba32ui) writeonly uniform uimage2DArray new_guide_image;
layout(binding = 12, rgba32f) writeonly uniform image2DArray new_known_image;
layout(binding = 13, rgba32f) writeonly uniform image2DArray new_standing_image;
layout(binding = 14, rg32f) writeonly uniform image2DArray new_trend_image;
// With FINISH.
layout(binding = 15) uniform sampler2D environment_map;
layout(binding = 16) uniform sampler2D irradiance_map;
layout(binding = 17) uniform sampler2D specular_map;
layout(binding = 18) uniform sampler2D brdf_table;
layout(binding = 19, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 20, rgba16f) writeonly uniform image2DArray reflection_image;
// With MOVES: for each instance the three rows of the matrix that takes a point from where it is to where it was in the last
// frame; and the images that tell which instance a pixel reflects.
layout(binding = 21, std430) readonly buffer Motions { vec4 motions[]; };
layout(binding = 22) uniform usampler2DArray hit_image;
layout(binding = 23) uniform usampler2DArray instance_image;
// has_history 0: there is no last frame. is_changing 1: some object has moved since the last frame.
layout(push_constant) uniform Constants { uint has_history; uint is_changing; };

#include "common/hit.glsl"
#include "common/reflect.glsl"
#include "common/shade.glsl"
#include "common/outgoing.glsl"
#include "common/store.glsl"

// Share of a new frame with constant weights (seed 003, §1).
const float CONSTANT_SHARE = 0.1;
// Half width of the history's clamp about the neighbourhood's mean, in standard deviations.
const float CLAMP_DEVIATIONS = 1.25;
// The weight of a frame in the running mean of differences, and that mean's variance divided by a single difference's.
const float TREND_RATE = 0.25;
const float TREND_VARIANCE = TREND_RATE / (2.0 - TREND_RATE);
// A running mean that is larger than this many of its standard deviations counts as bias.
const float TREND_DEVIATIONS = 4.0;
// Differences are clamped to this many standard deviations before they enter the running mean, so that no single outlier
// counts as bias.
const float OUTLIER = 3.0;
// Differences are clamped to this many standard deviations before the noise is learned from them, so that a change of the
// scene is not learned as noise.
const float LEARNED_OUTLIER = 6.0;
// A history that is brighter than the whole neighbourhood by this many standard deviations is biased at once. A darker one is
// biased only if the frames before were bright as well, because the noise of reflections has bright outliers and no dark
// ones: the running mean must exceed WAS_BRIGHT standard deviations.
const float OUTSIDE_DEVIATIONS = 2.0;
const float OUTSIDE_WHILE_CHANGING = 1.0;
const float WAS_BRIGHT = 0.5;
// The variance of a single frame is a running mean over at most this many frames, in which the filter's own estimate counts
// as PRIOR_FRAMES frames.
const float MOST_LEARNED = 32.0;
const float PRIOR_FRAMES = 3.0;
// A bilinear fetch between texels blurs the history by a sixth of a squared pixel on average. A moving history may be blurred
// no more than the lobe blurs the reflection. It therefore counts for at most FRAMES_A_LOBE frames times the square of the
// lobe's half width in pixels, within the two bounds below.
const float FRAMES_A_LOBE = 6.0;
// Fewer frames would not reduce the noise of narrow lobes.
const float LEAST_MOVING_FRAMES = 6.0;
const float MOST_MOVING_FRAMES = 32.0;
// While an object moves, any reflection may change. The history then counts for fewer frames and is taken as biased sooner
// (OUTSIDE_WHILE_CHANGING).
const float MOST_CHANGING_FRAMES = 1.0;

// The surface's history is used where its mismatch is less than this share of the virtual image's.
const float BETTER_SURFACE = 0.25;

struct History {
    vec4 light;      // C·L, C
    vec4 standing;   // Σ w, nearness, variance, frames
    vec2 trend;      // variance of a single frame, running mean of differences
    float weight;    // Σ w of a single frame
    float shown;     // bilinear weight of the texels that show the same surface; 0: no history
    vec2 pixel;
};

const History NO_HISTORY = History(vec4(0.0), vec4(0.0), vec2(0.0), 0.0, 0.0, vec2(0.0));

// Statistics of this frame's light over those of the 3×3 pixels that show the same instance.
struct Neighbourhood {
    float known;     // number of pixels whose light is at least partly known
    vec3 mean;       // of L
    vec3 deviation;
    float least;     // this and the next three: of the luminance of L
    float most;
    float average;
    float variance;
};

float known_luminance(vec4 light) { return light.a > 0.0 ? luminance(light.rgb) / light.a : 0.0; }

// Where a point of an instance (id + 1; 0: none) was in the last frame. at.w is 1 for a point and 0 for a direction.
vec3 moved(uint instance, vec4 at) {
    if (MOVES == 0u || instance == 0u) return at.xyz;
    uint first = (instance - 1u) * 3u;
    return vec3(dot(motions[first], at), dot(motions[first + 1u], at), dot(motions[first + 2u], at));
}

// The instance (id + 1) that a pixel's own ray hit within a view; 0: none.
uint reflected_instance(ivec3 texel) {
    if (MOVES == 0u) return 0u;
    Hit h = unpack_hit(texelFetch(hit_image, texel, 0));
    if (h.status != HIT) return 0u;
    ivec2 at = min(ivec2(h.uv * vec2(frame.size)), ivec2(frame.size) - 1);
    return texelFetch(instance_image, ivec3(at, h.eye), 0).x;
}

// Pixel of the last frame's eye; false: beyond its view.
bool last_pixel(uint eye, vec3 at, out vec2 pixel) {
    vec4 clip = last.eyes[eye].clip_from_render * vec4(at, 1.0);
    pixel = screen_from_clip(clip).xy;
    return clip.w > 0.0 && all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, vec2(frame.size)));
}

vec3 last_position(uint eye, vec2 pixel, float depth) {
    vec3 ray = last.eyes[eye].ray_first.xyz + pixel.x * last.eyes[eye].ray_across.xyz + pixel.y * last.eyes[eye].ray_down.xyz;
    return last.eyes[eye].position_near.xyz + ray * (last.eyes[eye].position_near.w / depth);
}

// The history at a place of the last frame, in pixels: bilinear over those of the four texels that show p's surface, which
// was at `was` with the normals `normal_was` and `face_was`.
History history_at(Pixel p, vec3 was, vec3 normal_was, vec3 face_was, vec2 pixel) {
    History h = NO_HISTORY;
    h.pixel = pixel;
    uint eye = uint(p.texel.z);
    vec2 corner = floor(pixel - 0.5), part = pixel - 0.5 - corner;
    for (int i = 0; i < 4; ++i) {
        ivec2 offset = ivec2(i & 1, i >> 1);
        vec2 share = mix(1.0 - part, part, vec2(offset));
        float weight = share.x * share.y;
        ivec2 at = ivec2(corner) + offset;
        if (weight < 1e-3 || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(frame.size)))) continue;
        ivec3 texel = ivec3(at, p.texel.z);
        Guide g = unpack_guide(texelFetch(last_guide_image, texel, 0));
        if (g.instance != p.instance) continue;
        if ((g.roughness < frame.delta_roughness) != is_mirror(p.surface)) continue;
        if (dot(unpack_direction(g.normal), normal_was) < LEAST_COSINE) continue;
        vec3 position = last_position(eye, vec2(at) + 0.5, g.depth);
        if (abs(dot(position - was, face_was)) > PLANE_TOLERANCE * p.distance) continue;
        vec4 standing = texelFetch(last_standing_image, texel, 0);
        if (standing.w <= 0.0) continue;
        h.light += weight * texelFetch(last_known_image, texel, 0);
        h.standing += weight * standing;
        h.trend += weight * texelFetch(last_trend_image, texel, 0).xy;
        h.shown += weight;
    }
    if (h.shown < 1e-3) return NO_HISTORY;
    h.light /= h.shown;
    h.standing /= h.shown;
    h.trend /= h.shown;
    h.weight = h.standing.x / max(h.standing.w, 1e-6);
    return h;
}

// The pixel in which the last frame's eye saw what p reflects from `far` metres away. The reflected point is moved back to
// the last frame and mirrored in the plane where p was; the line from the eye to this virtual image meets the plane in the
// pixel. False: that eye did not see it.
bool last_image(Pixel p, vec3 was, vec3 normal_was, float far, uint reflected, out vec2 pixel) {
    uint eye = uint(p.texel.z);
    vec3 point = moved(reflected, vec4(p.position + reflect(-p.v, p.surface.normal) * far, 1.0));
    vec3 from = last.eyes[eye].position_near.xyz;
    float height = dot(from - was, normal_was), along = dot(point - was, normal_was);
    if (height <= 0.0 || along < 0.0) return false;
    vec3 image = point - 2.0 * along * normal_was;
    return last_pixel(eye, from + (image - from) * (height / (height + along)), pixel);
}

Neighbourhood neighbourhood(Pixel p) {
    Neighbourhood n;
    n.known = 0.0;
    n.least = FLT_MAX;
    n.most = -FLT_MAX;
    vec3 sum = vec3(0.0), squares = vec3(0.0);
    float l_sum = 0.0, l_squares = 0.0;
    for (int i = 0; i < 9; ++i) {
        ivec3 texel = p.texel + ivec3(i % 3 - 1, i / 3 - 1, 0);
        if (any(lessThan(texel.xy, ivec2(0))) || any(greaterThanEqual(texel.xy, ivec2(frame.size)))) continue;
        if (load_guide(texel).instance != p.instance) continue;
        vec4 light = texelFetch(known_image, texel, 0);
        if (light.a <= 0.0) continue;
        vec3 color = light.rgb / light.a;
        float l = luminance(color);
        n.known += 1.0;
        sum += color;
        squares += color * color;
        n.least = min(n.least, l);
        n.most = max(n.most, l);
        l_sum += l;
        l_squares += l * l;
    }
    float count = max(n.known, 1.0);
    n.mean = sum / count;
    n.deviation = sqrt(max(squares / count - n.mean * n.mean, vec3(0.0)));
    n.average = l_sum / count;
    n.variance = max(l_squares / count - n.average * n.average, 0.0);
    return n;
}

// How badly a history fits this frame around the pixel: the difference of luminances in units of the noise, and the
// difference of the distances of what is reflected.
float mismatch(History h, Neighbourhood n, float variance, float nearness) {
    float light = square(known_luminance(h.light) - n.average) / max(n.variance + variance, 1e-12);
    float there = h.standing.y;
    float place = nearness > 0.0 && there > 0.0 ? square((there - nearness) / (0.1 * max(there, nearness))) : 0.0;
    return min(light, 100.0) + 0.25 * min(place, 100.0);
}

// Squared bias of the history, after subtracting what noise explains. noise: variance of a frame's difference from the
// history; before, trend: the running mean without and with this frame.
float squared_bias(History h, Neighbourhood n, float noise, float before, float trend) {
    float deviation = sqrt(noise), l = known_luminance(h.light);
    float margin = (is_changing != 0u ? OUTSIDE_WHILE_CHANGING : OUTSIDE_DEVIATIONS) * deviation;
    float lasting = square(trend) - square(TREND_DEVIATIONS) * TREND_VARIANCE * noise;
    float outside = l - n.most - margin;
    if (before > WAS_BRIGHT * deviation) outside = max(outside, n.least - l - margin);
    return max(max(lasting, 0.0), square(max(outside, 0.0)));
}

void store(Pixel p, vec4 light, vec4 standing, vec2 trend) {
    imageStore(new_known_image, p.texel, vec4(storable(light.rgb), light.a));
    imageStore(new_standing_image, p.texel, standing);
    imageStore(new_trend_image, p.texel, vec4(trend, 0.0, 0.0));
    if (FINISH != 0u) {
        imageStore(reflection_image, p.texel, vec4(storable(outgoing(p, light.rgb, light.a)), light.a));
    }
}

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (any(greaterThanEqual(texel.xy, ivec2(frame.size)))) return;
    uvec4 word = texelFetch(guide_image, texel, 0);
    imageStore(new_guide_image, texel, word);
    if (unpack_guide(word).instance == 0u) return;

    Pixel p = load_pixel(texel);
    uint eye = uint(texel.z);
    vec4 own = texelFetch(known_image, texel, 0);
    vec4 standing = vec4(texelFetch(standing_image, texel, 0).xyz, 1.0);
    // A mirror has no noise that a history could reduce.
    if (has_history == 0u || is_mirror(p.surface)) {
        store(p, own, standing, vec2(standing.z, 0.0));
        return;
    }

    vec3 was = moved(p.instance, vec4(p.position, 1.0));
    vec3 normal_was = normalize(moved(p.instance, vec4(p.surface.normal, 0.0)));
    vec3 face_was = normalize(moved(p.instance, vec4(p.surface.face_normal, 0.0)));
    float eye_distance = distance(eye_position(eye), p.position);
    float last_eye_distance = distance(last.eyes[eye].position_near.xyz, was);
    History of_surface = NO_HISTORY, of_image = NO_HISTORY;
    vec2 pixel;
    bool needs_surface = SOURCE != 2u || standing.y <= 0.0;
    if (needs_surface && last_pixel(eye, was, pixel)) of_surface = history_at(p, was, normal_was, face_was, pixel);
    if (SOURCE != 1u) {
        // Where this frame does not know the distance of what is reflected, the surface's history may know it.
        float nearness = standing.y;
        float far = nearness > 0.0 ? 1.0 / nearness - eye_distance
                                   : 1.0 / max(of_surface.standing.y, 1e-9) - last_eye_distance;
        bool is_known = nearness > 0.0 || of_surface.standing.y > 0.0;
        if (is_known && last_image(p, was, normal_was, max(far, 0.0), reflected_instance(texel), pixel)) {
            bool same = of_surface.shown > 0.0 && distance(pixel, of_surface.pixel) < 1e-2;
            if (same) of_image = of_surface;
            else of_image = history_at(p, was, normal_was, face_was, pixel);
        }
    }
    Neighbourhood n = neighbourhood(p);
    History h = of_image;
    if (SOURCE == 1u || of_image.shown <= 0.0) {
        h = of_surface;
    } else if (SOURCE == 0u && of_surface.shown > 0.0) {
        float a = mismatch(of_surface, n, standing.z, standing.y), b = mismatch(of_image, n, standing.z, standing.y);
        // The virtual image's history is right unless it belongs to something else at that place.
        if (a < BETTER_SURFACE * b) h = of_surface;
    }
    if (h.shown <= 0.0) {
        store(p, own, standing, vec2(standing.z, 0.0));
        return;
    }

    bool moving = distance(h.pixel, vec2(texel.xy) + 0.5) > 1e-2;
    if (moving || is_changing != 0u) {
        float far = max(1.0 / max(standing.y, 1e-9) - eye_distance, 0.0);
        float lobe = lobe_pixels(p, far);
        h.standing.w = min(h.standing.w, clamp(FRAMES_A_LOBE * lobe * lobe, LEAST_MOVING_FRAMES, MOST_MOVING_FRAMES));
    }
    if (is_changing != 0u) h.standing.w = min(h.standing.w, MOST_CHANGING_FRAMES);
    float frames = max(h.standing.w, 0.1);
    float share = 1.0 / (frames + 1.0), variance = h.trend.x, trend = h.trend.y;
    if (WEIGHTS != 0u) {
        share = max(CONSTANT_SHARE, share);
        if (WEIGHTS == 2u) {
            vec3 reach = CLAMP_DEVIATIONS * n.deviation;
            // L is clamped, and not C·L, which also depends on how much of the light is known.
            vec3 l = h.light.rgb / max(h.light.a, 1e-6);
            if (n.known > 0.0) h.light.rgb = clamp(l, n.mean - reach, n.mean + reach) * h.light.a;
        }
    } else if (own.a > 0.0 && h.light.a > 0.0) {
        float difference = known_luminance(own) - known_luminance(h.light);
        float noise = variance * (1.0 + 1.0 / frames), deviation = sqrt(noise);
        float before = trend;
        trend = mix(trend, clamp(difference, -OUTLIER * deviation, OUTLIER * deviation), TREND_RATE);
        float bias2 = squared_bias(h, n, noise, before, trend);
        // 1 − σ²/(bias² + σ²/N + σ²), with σ² the variance of a frame. Without noise the new frame is right.
        share = variance > 1e-20 ? 1.0 - variance / (bias2 + noise) : 1.0;
        // The share of this frame that enters the history no longer differs from it.
        trend *= bias2 > 0.0 ? 1.0 - share : 1.0;
        float learned = min(frames, MOST_LEARNED) + PRIOR_FRAMES;
        float known_noise = max(noise, max(standing.z, n.variance));
        float squared = min(square(difference), square(LEARNED_OUTLIER) * known_noise);
        variance += (squared * frames / (frames + 1.0) - variance) / (learned + 1.0);
    }
    vec4 light = mix(h.light, own, share);
    float count = 1.0 / max(square(share) + square(1.0 - share) / frames, 1e-12);
    // The distance of what is reflected, from this frame's eye.
    float nearness = standing.y;
    if (h.standing.y > 0.0) {
        float there = 1.0 / (max(1.0 / h.standing.y - last_eye_distance, 0.0) + eye_distance);
        nearness = nearness > 0.0 ? mix(there, nearness, share) : there;
    }
    float weight = mix(h.weight, standing.x, share);
    // `weight` is Σ w of a single frame; the history keeps Σ w of all its frames and the variance of their mean.
    vec4 standing_now = vec4(weight * count, nearness, variance / count, count);
    store(p, light, standing_now, vec2(variance, trend));
}
