#version 460
// In: G-buffer, lights, the scene's BVH. Out: the outgoing light of the punctual lights at each pixel, with shadows. With
// REUSE: at each pixel of the left eye, or at the listed pixels of the right eye; for the left eye also its diffuse part
// without the albedo, and what is known of its lights.
// The random numbers of soft shadows do not depend on the seed. A view's shadows are therefore as fixed as its geometry,
// whatever method runs on top of them.
// Reference: never with REUSE.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;
layout(constant_id = 1) const uint HAS_GLASS = 1u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Lights { LightData lights[]; };
#ifdef RAY_QUERY
layout(binding = 2) uniform accelerationStructureEXT ray_structure;
#else
layout(binding = 2) uniform usampler2D node_rows;
#endif
layout(binding = 3) uniform usampler2D triangle_rows;
layout(binding = 4, std430) readonly buffer Instances { InstanceData instances[]; };
layout(binding = 5, std430) readonly buffer Materials { MaterialData materials[]; };
layout(binding = 6, std430) readonly buffer Textures { TextureData textures[]; };
layout(binding = 7, std430) readonly buffer Texels { uint texels[]; };
layout(binding = 8, std430) readonly buffer Vertices { float vertices[]; };
layout(binding = 9, std430) readonly buffer Indices { uint indices[]; };
layout(binding = 10) uniform usampler2DArray surface_image;
layout(binding = 11) uniform sampler2DArray depth_image;
layout(binding = 12, rgba32f) writeonly uniform image2DArray direct_image;
// rim_rays, soft_rays: the numbers of rays to a light that has a size: first to its rim, then in a penumbra.
#ifdef REUSE
layout(binding = 13, rgba16f) writeonly uniform image2D diffuse_image;
layout(binding = 14, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 15, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 16, rgba32ui) uniform uimage2DArray known_image;
layout(push_constant) uniform Constants { uint rim_rays; uint soft_rays; uint listed; };
#else
layout(push_constant) uniform Constants { uint rim_rays; uint soft_rays; };
#endif

#include "common/camera.glsl"
#include "common/hit_surface.glsl"
#include "common/lights.glsl"
#include "common/shadow.glsl"
#ifdef REUSE
#include "common/known_lights.glsl"
#include "common/left_or_listed.glsl"
#endif

// The share of light i that reaches a point. For a light with a size, a few rays to the rim of its disc first ask whether all
// of the rim is equally visible. If it is, all of the disc counts as visible or hidden: an edge across the disc that none of
// six rays finds hides at most 3 % of it.
vec3 mean_share(uint i, vec3 position, vec3 face_normal, uint eye, uvec2 pixel) {
    if (lights[i].size == 0.0) return light_share(lights[i], position, face_normal, vec2(0.0));
    float turn = draw_1d(0u, eye, pixel, i, DRAW_RIM);
    vec3 low = vec3(1.0), high = vec3(0.0);
    for (uint k = 0u; k < rim_rays; ++k) {
        float phi = 2.0 * PI * (float(k) + turn) / float(rim_rays);
        vec3 share = light_share(lights[i], position, face_normal, vec2(cos(phi), sin(phi)));
        low = min(low, share);
        high = max(high, share);
    }
    // The tolerance is there because the share that glass lets through is rounded differently for each order of surfaces.
    if (all(lessThan(high - low, vec3(1e-3)))) return low;
    vec3 sum = vec3(0.0);
    for (uint k = 0u; k < soft_rays; ++k) {
        vec2 u = draw_2d(Draws(0u, eye, pixel, k), DRAW_LIGHT + i);
        sum += light_share(lights[i], position, face_normal, on_disc(u));
    }
    return sum / float(soft_rays);
}

void main() {
#ifdef REUSE
    ivec3 texel;
    if (!left_or_listed(texel)) return;
    uvec3 id = uvec3(texel);
    vec3 diffuse = vec3(0.0);
    uvec4 known = listed != 0u ? imageLoad(known_image, texel) : uvec4(0u);
#else
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
#endif
    uint eye = id.z;
    // A pixel that is shown has the same random numbers with a guard band as without one. In the band the numbers wrap around.
    uvec2 shown = id.xy - frame.guard;
    vec2 center = vec2(id.xy) + 0.5;
    float depth = texelFetch(depth_image, texel, 0).x;
    vec3 direct = vec3(0.0);
    if (depth != 0.0) {
        Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
        vec3 position = render_position(eye, center, depth);
        vec3 v = normalize(eye_position(eye) - position);
        for (uint i = 0u; i < frame.light_count; ++i) {
#ifdef REUSE
            vec3 of_light;
            vec3 light = from_light_with_diffuse(lights[i], s, position, v, of_light);
#else
            vec3 light = from_light(lights[i], s, position, v);
#endif
            if (all(equal(light, vec3(0.0)))) continue;
#ifdef REUSE
            vec3 share;
            if (!is_known(known, i, share)) {
                share = mean_share(i, position, s.face_normal, eye, shown);
                if (listed == 0u) learn(known, i, share);
            }
            direct += light * share;
            diffuse += of_light * share;
#else
            direct += light * mean_share(i, position, s.face_normal, eye, shown);
#endif
        }
    }
    imageStore(direct_image, texel, vec4(direct, 1.0));
#ifdef REUSE
    if (listed == 0u) {
        imageStore(diffuse_image, texel.xy, vec4(min(diffuse, vec3(65504.0)), 1.0));
        imageStore(known_image, texel, known);
    }
#endif
}
