#version 460
// In: G-buffer, lights (with SHADOWS their light as another pass has computed it), environment (with INDIRECT baked light),
// with HAS_AO the visibility of the surroundings. Out: radiance of each pixel without its traced reflection (paper §3). The
// background is the environment.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_EMISSION = 1u;
layout(constant_id = 1) const uint SHADOWS = 1u;
layout(constant_id = 2) const uint INDIRECT = 1u;
// 1: ambient occlusion dims the environment's or the baked light.
layout(constant_id = 3) const uint HAS_AO = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 2, std430) buffer Counters { CountersData counters; };
layout(binding = 3) uniform usampler2DArray surface_image;
layout(binding = 4) uniform sampler2DArray depth_image;
layout(binding = 5) uniform sampler2D environment_map;
layout(binding = 6) uniform sampler2D irradiance_map;
layout(binding = 7) uniform sampler2D specular_map;
layout(binding = 8) uniform sampler2D brdf_table;
layout(binding = 9, rgba16f) writeonly uniform image2DArray radiance_image;
layout(binding = 10) uniform sampler2DArray emission_image;
layout(binding = 11) uniform sampler2DArray direct_image;
layout(binding = 12) uniform sampler2DArray indirect_image;
layout(binding = 13) uniform sampler2DArray visibility_image;

#include "common/camera.glsl"
#include "common/shade.glsl"
#include "common/store.glsl"

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    uint eye = id.z;
    vec2 center = vec2(id.xy) + 0.5;
    float depth = texelFetch(depth_image, texel, 0).x;
    vec3 radiance;
    if (depth == 0.0) {
        radiance = environment_radiance(pixel_direction(eye, center));
    } else {
        Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
        vec3 position = render_position(eye, center, depth);
        vec3 emission = HAS_EMISSION != 0u ? texelFetch(emission_image, texel, 0).rgb : vec3(0.0);
        if (HAS_AO != 0u) {
            // With antialiasing, a sample of the finer view takes the visibility of the pixel in which it lies.
            ivec2 there = texel.xy * textureSize(visibility_image, 0).xy / ivec2(frame.size);
            ambient_visibility = texelFetch(visibility_image, ivec3(there, texel.z), 0).x;
        }
        vec3 v = normalize(eye_position(eye) - position);
        if (SHADOWS + INDIRECT == 0u) {
            radiance = shade(s, emission, position, v);
        } else {
            radiance = INDIRECT != 0u
                     ? shade_without_lights_in(texelFetch(indirect_image, texel, 0).rgb, s, emission, v)
                     : shade_without_lights(s, emission, v);
            if (SHADOWS != 0u) {
                radiance += texelFetch(direct_image, texel, 0).rgb;
            } else {
                for (uint i = 0u; i < frame.light_count; ++i) radiance += from_light(lights[i], s, position, v);
            }
        }
    }
    imageStore(radiance_image, texel, vec4(storable(radiance), 1.0));
}
