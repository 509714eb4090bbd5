#version 460
// In: rays that the views lost, G-buffer, the scene's BVH. Out: their hits, and the radiance of the hits that neither eye sees.
// A hit that an eye sees takes that pixel's radiance, as every hit of the screen-space march does. Any other hit is shaded as
// the reference shades it (path_trace.comp).
// Reference: never.
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
layout(binding = 21, rgba32ui) uniform uimage2DArray hit_image;
layout(binding = 22, rgba16f) writeonly uniform image2DArray ray_radiance_image;
layout(push_constant) uniform Constants { uint sample_index; };

#include "common/camera.glsl"
#include "common/hit.glsl"
#include "common/random.glsl"
#include "common/ray_list.glsl"
#include "common/reflect.glsl"
#include "common/store.glsl"
#include "common/hit_surface.glsl"
#include "common/shade_hit.glsl"

shared uint hit_count;
shared uint sky_count;
shared uint asked_count;

// Whether an eye sees the point that a ray along `direction` hit: the pixel at that place shows the side that was hit, and its
// surface's plane passes the point within half a pixel's footprint.
bool is_seen(uint eye, vec3 position, vec3 direction, out ivec3 at) {
    at = ivec3(0);
    vec4 clip = frame.eyes[eye].clip_from_render * vec4(position, 1.0);
    if (clip.w <= frame.eyes[eye].position_near.w) return false;
    vec2 pixel = screen_from_clip(clip).xy;
    if (any(lessThan(pixel, vec2(0.0))) || any(greaterThanEqual(pixel, vec2(frame.size)))) return false;
    at = ivec3(ivec2(pixel), eye);
    float depth = texelFetch(depth_image, at, 0).x;
    if (depth == 0.0) return false;
    vec3 face = unpack_direction(texelFetch(surface_image, at, 0).y);
    if (dot(face, direction) >= 0.0) return false;
    vec3 there = render_position(eye, vec2(at.xy) + 0.5, depth);
    float footprint = pixel_size(eye) * view_distance(eye, depth);
    return abs(dot(position - there, face)) <= 0.5 * footprint && distance(position, there) <= 16.0 * footprint;
}

void trace_listed(ivec3 texel) {
    uint eye = uint(texel.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    vec3 origin = ray_origin(eye, position, s.face_normal, depth);
    Draws draws = Draws(combine(frame.seed, frame.frame), frame.eyes[eye].stream.x, uvec2(texel.xy), sample_index);
    ReflectionRay ray = reflection_ray(s, v, sample_2d(draws.seed, draws.token, draws.pixel, draws.index));
    Hit hit = Hit(SKY, vec2(0.0), eye, ray.direction, 0.0, ray.pdf, 1.0);
    atomicAdd(asked_count, 1u);
    Intersection found = intersect(origin, ray.direction);
    if (found.triangle == NO_TRIANGLE) {
        atomicAdd(sky_count, 1u);
        imageStore(hit_image, texel, pack_hit(hit));
        return;
    }
    atomicAdd(hit_count, 1u);
    vec3 there = origin + ray.direction * found.t;
    hit.distance = found.t;
    ivec3 at;
    bool seen = is_seen(eye, there, ray.direction, at) || is_seen(1u - eye, there, ray.direction, at);
    if (seen) {
        hit.status = HIT;
        hit.eye = uint(at.z);
        hit.uv = (vec2(at.xy) + 0.5) / vec2(frame.size);
    } else {
        vec3 emission;
        Surface other = hit_surface(found, -ray.direction, emission);
        vec3 radiance = shade_hit(other, emission, found, there, -ray.direction, draws);
        hit.status = SHADED;
        imageStore(ray_radiance_image, texel, vec4(storable(radiance), 0.0));
    }
    imageStore(hit_image, texel, pack_hit(hit));
}

void main() {
    uint i = gl_LocalInvocationIndex;
    if (i == 0u) {
        asked_count = 0u;
        hit_count = 0u;
        sky_count = 0u;
    }
    barrier();
    ivec3 texel;
    if (listed_pixel(texel)) trace_listed(texel);
    barrier();
    if (i == 0u) {
        atomicAdd(counters.asked, asked_count);
        atomicAdd(counters.hits, hit_count);
        atomicAdd(counters.sky, sky_count);
    }
}
