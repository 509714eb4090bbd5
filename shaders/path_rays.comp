#version 460
// In: ray list, G-buffer, the scene's BVH. Out: for each listed pixel the hit of one reflection ray and the radiance there.
// The ray is the reference's (path_trace.comp), and its hit goes to the filter of the screen-space methods (resolve.comp).
// Together they are path tracing with a few paths per pixel and a denoiser, in real time.
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
layout(binding = 21, rgba32ui) writeonly uniform uimage2DArray hit_image;
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

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uint eye = uint(texel.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
    vec3 position = render_position(eye, vec2(texel.xy) + 0.5, depth);
    vec3 v = normalize(eye_position(eye) - position);
    vec3 origin = ray_origin(eye, position, s.face_normal, depth);
    Draws draws = Draws(combine(frame.seed, frame.frame), frame.eyes[eye].stream.x, uvec2(texel.xy), sample_index);
    ReflectionRay ray = reflection_ray(s, v, sample_2d(draws.seed, draws.token, draws.pixel, draws.index));
    Hit hit = Hit(NOTHING, vec2(0.0), eye, ray.direction, 0.0, ray.pdf, ray.above ? 1.0 : 0.0);
    vec3 radiance = vec3(0.0);
    if (!ray.open) {
        atomicAdd(counters.below_horizon, 1u);
    } else {
        atomicAdd(counters.rays, 1u);
        hit.confidence = 1.0;
        Intersection found = intersect(origin, ray.direction);
        if (found.triangle == NO_TRIANGLE) {
            atomicAdd(counters.sky, 1u);
            hit.status = SKY;
            radiance = environment_radiance(ray.direction);
        } else {
            atomicAdd(counters.hits, 1u);
            vec3 emission;
            Surface other = hit_surface(found, -ray.direction, emission);
            radiance = shade_hit(other, emission, found, origin + ray.direction * found.t, -ray.direction, draws);
            hit.status = HIT;
            hit.distance = found.t;
        }
    }
    imageStore(hit_image, texel, pack_hit(hit));
    imageStore(ray_radiance_image, texel, vec4(storable(radiance), 0.0));
}
