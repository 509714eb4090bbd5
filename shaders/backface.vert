#version 460
// In: vertices, instances, the eye. Out: clip position. Its depths must equal those of gbuffer.vert to the bit.
// The paper's §4.1: dual depth.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(set = 0, binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(push_constant) uniform Constants { uint eye; };
layout(location = 0) in vec3 position;

// This pass and the G-buffer's must give the same depths.
invariant gl_Position;

void main() {
    InstanceData instance = instances[gl_InstanceIndex];
    vec4 p = vec4(position, 1.0);
    vec3 world = vec3(dot(instance.render_from_object[0], p), dot(instance.render_from_object[1], p),
                      dot(instance.render_from_object[2], p));
    gl_Position = frame.eyes[eye].clip_from_render * vec4(world, 1.0);
}
