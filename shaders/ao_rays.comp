#version 460
// In: G-buffer, the scene's triangles. Out: visibility by rays, against which the screen-space estimates are judged. The rays
// are cosine-weighted about the triangle's normal. A hit at distance t hides max(1 − t²/radius², 0) of its ray, which is the
// falloff of the estimates.
// Progressive: the sum is kept, and each dispatch adds rays to it. Nothing is filtered.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;
const uint HAS_GLASS = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
#ifdef RAY_QUERY
layout(binding = 1) uniform accelerationStructureEXT ray_structure;
#else
layout(binding = 1) uniform usampler2D node_rows;
#endif
layout(binding = 2) uniform usampler2D triangle_rows;
layout(binding = 3, std430) readonly buffer Instances { InstanceData instances[]; };
layout(binding = 4, std430) readonly buffer Materials { MaterialData materials[]; };
layout(binding = 5, std430) readonly buffer Textures { TextureData textures[]; };
layout(binding = 6, std430) readonly buffer Texels { uint texels[]; };
layout(binding = 7, std430) readonly buffer Vertices { float vertices[]; };
layout(binding = 8, std430) readonly buffer Indices { uint indices[]; };
layout(binding = 9) uniform usampler2DArray surface_image;
layout(binding = 10) uniform sampler2DArray depth_image;
layout(binding = 11, r32f) uniform image2DArray sum_image;
layout(binding = 12, r32f) writeonly uniform image2DArray visibility_image;
layout(push_constant) uniform Constants {
    float radius;       // metres
    uint first_ray;
    uint ray_count;
};

#include "common/camera.glsl"
#include "common/random.glsl"
#include "common/hit_surface.glsl"

// Purpose of the random numbers.
const uint DRAW_AO_RAY = 18u;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    // All invocations of a group belong to one eye, so that a software device loads the eye's constants once for all lanes.
    ivec3 texel = ivec3(id.xy, gl_WorkGroupID.z);
    float depth = texelFetch(depth_image, texel, 0).x;
    if (depth == 0.0) {
        imageStore(visibility_image, texel, vec4(1.0));
        return;
    }
    vec3 position = render_position(texel.z, vec2(texel.xy) + 0.5, depth);
    vec3 normal = unpack_direction(texelFetch(surface_image, texel, 0).y);
    vec3 origin = ray_origin(uint(texel.z), position, normal, depth);
    mat3 local = basis(normal);
    uint seed = combine(combine(frame.seed, frame.frame), DRAW_AO_RAY);
    float sum = first_ray > 0u ? imageLoad(sum_image, texel).x : 0.0;
    for (uint i = first_ray; i < first_ray + ray_count; ++i) {
        vec2 u = sample_2d(seed, frame.eyes[texel.z].stream.x, uvec2(texel.xy), i);
        vec2 disk = sqrt(u.x) * vec2(cos(2.0 * PI * u.y), sin(2.0 * PI * u.y));
        vec3 direction = normalize(local * vec3(disk, sqrt(max(1.0 - u.x, 0.0))));
        float t = min(intersect(origin, direction).t / radius, 1.0);
        sum += t * t;
    }
    imageStore(sum_image, texel, vec4(sum));
    imageStore(visibility_image, texel, vec4(sum / float(first_ray + ray_count)));
}
