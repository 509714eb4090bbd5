#version 460
// In: G-buffer, the scene's BVH, baked light. Out: baked light (irradiance / π) of each pixel's surface.
// The G-buffer does not hold the triangle of a pixel, so a short ray that starts just before the surface finds it.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;

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
layout(binding = 9) uniform sampler2DArray depth_image;
layout(binding = 10) uniform usampler2D patch_rows;
layout(binding = 11) uniform usampler2D light_rows;
layout(binding = 12, rgba16f) writeonly uniform image2DArray indirect_image;

const uint HAS_GLASS = 0u;
#include "common/camera.glsl"
#include "common/hit_surface.glsl"
#include "common/baked.glsl"

// How far before the surface the ray starts, as a share of the distance from the eye.
const float BEFORE = 2e-3;

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    uint eye = id.z;
    vec2 center = vec2(id.xy) + 0.5;
    float depth = texelFetch(depth_image, texel, 0).x;
    vec3 light = vec3(0.0);
    if (depth != 0.0) {
        vec3 position = render_position(eye, center, depth);
        vec3 along = position - eye_position(eye);
        float reach = length(along);
        along /= reach;
        Intersection hit = intersect(position - along * (BEFORE * reach), along);
        // Rounding may let the short ray slip between two triangles. Then a ray from the eye finds the triangle.
        if (hit.triangle == NO_TRIANGLE || hit.t > 4.0 * BEFORE * reach) hit = intersect(eye_position(eye), along);
        if (hit.triangle != NO_TRIANGLE) light = baked_light(hit.triangle, hit.uv, sees_back(hit.triangle, along));
    }
    imageStore(indirect_image, texel, vec4(min(light, vec3(65504.0)), 1.0));
}
