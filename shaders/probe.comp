#version 460
// In: the scene's BVH, lights, environment. Out: the radiance that arrives at one place from all around, as an equirectangular
// map. Unknown rays see it where the scene asks for a probe. Hits are shaded like the reference's.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;
layout(constant_id = 1) const uint SHADOWS = 1u;
layout(constant_id = 2) const uint HAS_GLASS = 1u;
layout(constant_id = 3) const uint INDIRECT = 1u;

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
layout(binding = 10) uniform sampler2D environment_map;
layout(binding = 11) uniform sampler2D irradiance_map;
layout(binding = 12) uniform sampler2D specular_map;
layout(binding = 13) uniform sampler2D brdf_table;
layout(binding = 14) uniform usampler2D patch_rows;
layout(binding = 15) uniform usampler2D light_rows;
layout(binding = 16, rgba32f) writeonly uniform image2D probe_image;
// xyz: the place, render space; w: number of samples for each texel.
layout(push_constant) uniform Constants { vec4 place; };

#include "common/random.glsl"
#include "common/hit_surface.glsl"
#include "common/shade_hit.glsl"

void main() {
    uvec2 id = gl_GlobalInvocationID.xy;
    uvec2 size = uvec2(imageSize(probe_image));
    if (any(greaterThanEqual(id, size))) return;
    uint samples = uint(place.w);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < samples; ++i) {
        // The inverse of equirect_uv in environment.glsl.
        vec2 uv = (vec2(id) + sample_2d(0u, 0u, id, i)) / vec2(size);
        float phi = (uv.x - 0.5) * 2.0 * PI, theta = uv.y * PI;
        vec3 d = vec3(sin(theta) * sin(phi), cos(theta), -sin(theta) * cos(phi));
        Intersection hit = intersect(place.xyz, d);
        if (hit.triangle == NO_TRIANGLE) {
            sum += environment_radiance(d);
            continue;
        }
        vec3 emission;
        Surface s = hit_surface(hit, -d, emission);
        sum += min(shade_hit(s, emission, hit, place.xyz + d * hit.t, -d, Draws(0u, 0u, id, i)), vec3(65504.0));
    }
    imageStore(probe_image, ivec2(id), vec4(sum / float(samples), 1.0));
}
