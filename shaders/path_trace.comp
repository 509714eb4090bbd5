#version 460
// In: ray list, G-buffer, the scene's BVH. Out: mean outgoing reflection of each listed pixel and its standard error. The
// mean's alpha is 1 / the distance of what is reflected (1/m; 0 the sky, −1 unknown), averaged with the samples' weights.
// The paper's reference (§5): two bounces. Each hit is shaded as `lighting` shades, and a miss sees the environment.
// Progressive: the sums are kept (compensated, Kahan 1965), and each dispatch adds samples to them.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#include "common/shared.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;
layout(constant_id = 1) const uint SHADOWS = 1u;
layout(constant_id = 2) const uint HAS_GLASS = 1u;
layout(constant_id = 3) const uint INDIRECT = 1u;

#include "common/geometry_rays.glsl"
// Image by image: Σ L and the number of samples; the compensation of Σ L, and Σ w/distance; Σ L² and Σ w. w is the luminance
// of a sample's weight.
layout(binding = 21, rgba32f) uniform image2DArray sum_image;
layout(binding = 22, rgba32f) uniform image2DArray compensation_image;
layout(binding = 23, rgba32f) uniform image2DArray square_image;
layout(binding = 24, rgba32f) writeonly uniform image2DArray reflection_image;
layout(binding = 25, rgba32f) writeonly uniform image2DArray error_image;
layout(push_constant) uniform Constants { uint first_sample; uint sample_count; };

#include "common/camera.glsl"
#include "common/random.glsl"
#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/hit_surface.glsl"
#include "common/shade_hit.glsl"

struct Tally {
    uint below_horizon;
    uint sky;
    uint hits;
    uint nan;
    uint clamped;
    vec2 nearness;      // Σ w/distance, Σ w
};

vec3 reflected(Surface s, vec3 v, vec3 origin, Draws draws, inout Tally tally) {
    vec2 u = sample_2d(draws.seed, draws.token, draws.pixel, draws.index);
    ReflectionRay ray = reflection_ray(s, v, u);
    if (!ray.open) {
        ++tally.below_horizon;
        return vec3(0.0);
    }
    vec3 weight = reflection_weight(s, v, ray.direction, ray.pdf);
    tally.nearness.y += luminance(weight);
    Intersection hit = intersect(origin, ray.direction);
    if (hit.triangle == NO_TRIANGLE) {
        ++tally.sky;
        return weight * environment_radiance(ray.direction);
    }
    ++tally.hits;
    tally.nearness.x += luminance(weight) / max(hit.t, 1e-6);
    vec3 emission;
    Surface other = hit_surface(hit, -ray.direction, emission);
    vec3 radiance = shade_hit(other, emission, hit, origin + ray.direction * hit.t, -ray.direction, draws);
    // Counted before `min`, which may replace a NaN by its other argument.
    if (any(isnan(radiance))) ++tally.nan;
    // Limited to what fp16 holds, because the screen-space methods cannot see more.
    if (any(greaterThanEqual(radiance, vec3(65504.0)))) ++tally.clamped;
    return weight * min(radiance, vec3(65504.0));
}

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uint eye = uint(texel.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    vec3 origin = ray_origin(eye, position, s.face_normal, depth);

    vec3 sum = vec3(0.0), compensation = vec3(0.0), squares = vec3(0.0);
    Tally tally = Tally(0u, 0u, 0u, 0u, 0u, vec2(0.0));
    if (first_sample > 0u) {
        sum = imageLoad(sum_image, texel).rgb;
        vec4 earlier = imageLoad(compensation_image, texel), earlier_squares = imageLoad(square_image, texel);
        compensation = earlier.rgb;
        squares = earlier_squares.rgb;
        tally.nearness = vec2(earlier.a, earlier_squares.a);
    }
    for (uint i = first_sample; i < first_sample + sample_count; ++i) {
        Draws draws = Draws(combine(frame.seed, frame.frame), frame.eyes[eye].stream.x, uvec2(texel.xy), i);
        vec3 x = reflected(s, v, origin, draws, tally);
        precise vec3 y = x - compensation;
        precise vec3 t = sum + y;
        compensation = (t - sum) - y;
        sum = t;
        squares += x * x;
    }
    atomicAdd(counters.below_horizon, tally.below_horizon);
    atomicAdd(counters.sky, tally.sky);
    atomicAdd(counters.hits, tally.hits);
    if (tally.nan > 0u) atomicAdd(counters.nan, tally.nan);
    if (tally.clamped > 0u) atomicAdd(counters.clamped, tally.clamped);
    atomicAdd(counters.rays, tally.sky + tally.hits);
    float n = float(first_sample + sample_count);
    imageStore(sum_image, texel, vec4(sum, n));
    imageStore(compensation_image, texel, vec4(compensation, tally.nearness.x));
    imageStore(square_image, texel, vec4(squares, tally.nearness.y));
    vec3 mean = sum / n;
    if (any(isnan(mean))) atomicAdd(counters.nan, 1u);
    if (any(isinf(mean))) atomicAdd(counters.inf, 1u);
    vec3 variance = max(squares / n - mean * mean, vec3(0.0)) * (n / max(n - 1.0, 1.0));
    float nearness = tally.nearness.y > 0.0 ? tally.nearness.x / tally.nearness.y : -1.0;
    imageStore(reflection_image, texel, vec4(mean, nearness));
    imageStore(error_image, texel, vec4(sqrt(variance / n), 0.0));
}
