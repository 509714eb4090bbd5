#version 460
// In: G-buffer, lights, the right eye's list of pixels. Out: the outgoing light of the punctual lights, without shadows, at each
// pixel of the left eye or at the listed pixels of the right eye; for the left eye also its diffuse part without the albedo.
// Runs only where the eyes share their shading (shading_reuse.comp); elsewhere lighting.comp adds the lights itself.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 2) uniform usampler2DArray surface_image;
layout(binding = 3) uniform sampler2DArray depth_image;
layout(binding = 4, rgba32f) writeonly uniform image2DArray direct_image;
layout(binding = 5, rgba16f) writeonly uniform image2D diffuse_image;
layout(binding = 6, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 7, std430) readonly buffer Arguments { uint arguments[4]; };
layout(push_constant) uniform Constants { uint listed; };

#include "common/camera.glsl"
#include "common/lights.glsl"
#include "common/left_or_listed.glsl"

void main() {
    ivec3 texel;
    if (!left_or_listed(texel)) return;
    uint eye = uint(texel.z);
    vec2 center = vec2(texel.xy) + 0.5;
    float depth = texelFetch(depth_image, texel, 0).x;
    vec3 direct = vec3(0.0), diffuse = vec3(0.0);
    if (depth != 0.0) {
        Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
        vec3 position = render_position(eye, center, depth);
        vec3 v = normalize(eye_position(eye) - position);
        for (uint i = 0u; i < frame.light_count; ++i) {
            vec3 of_light;
            direct += from_light_with_diffuse(lights[i], s, position, v, of_light);
            diffuse += of_light;
        }
    }
    imageStore(direct_image, texel, vec4(direct, 1.0));
    if (listed == 0u) imageStore(diffuse_image, texel.xy, vec4(min(diffuse, vec3(65504.0)), 1.0));
}
