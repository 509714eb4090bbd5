#version 460
// In: vertices, instances, the eye (push constant). Out: what gbuffer.frag needs.
// The first stage of the paper's §3. The eyes are drawn one after the other.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(set = 0, binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(push_constant) uniform Constants { uint eye; };

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec2 uv0;
layout(location = 4) in vec2 uv1;
layout(location = 5) in vec4 color;

layout(location = 0) out vec3 out_position;
layout(location = 1) out vec3 out_normal;
layout(location = 2) out vec4 out_tangent;
layout(location = 3) out vec4 out_uv;
layout(location = 4) out vec4 out_color;
layout(location = 5) flat out uint out_instance;

// This pass and the one of back faces must give the same depths.
invariant gl_Position;

void main() {
    InstanceData instance = instances[gl_InstanceIndex];
    vec4 p = vec4(position, 1.0);
    vec3 world = vec3(dot(instance.render_from_object[0], p), dot(instance.render_from_object[1], p),
                      dot(instance.render_from_object[2], p));
    out_position = world;
    out_normal = vec3(dot(instance.normal_matrix[0].xyz, normal), dot(instance.normal_matrix[1].xyz, normal),
                      dot(instance.normal_matrix[2].xyz, normal));
    vec4 t = vec4(tangent.xyz, 0.0);
    out_tangent = vec4(dot(instance.render_from_object[0], t), dot(instance.render_from_object[1], t),
                       dot(instance.render_from_object[2], t), tangent.w);
    out_uv = vec4(uv0, uv1);
    out_color = color;
    out_instance = gl_InstanceIndex;
    gl_Position = frame.eyes[eye].clip_from_render * vec4(world, 1.0);
}
