#version 460
// In: vertices, instances in the maps' space, the map's view. Out: what shadow_map.frag needs.
// A depth map from a light (Williams 1978), with reverse-Z as in the views.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(set = 0, binding = 0, std430) readonly buffer Maps { ShadowMapData maps[]; };
layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(push_constant) uniform Constants { uint map; };

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv0;
layout(location = 2) in vec2 uv1;
layout(location = 3) in vec4 color;

layout(location = 0) out vec4 out_uv;
layout(location = 1) out vec4 out_color;
layout(location = 2) flat out uint out_instance;

void main() {
    InstanceData instance = instances[gl_InstanceIndex];
    ShadowMapData view = maps[map];
    vec4 p = vec4(position, 1.0);
    vec4 world = vec4(dot(instance.render_from_object[0], p), dot(instance.render_from_object[1], p),
                      dot(instance.render_from_object[2], p), 1.0);
    vec2 across = vec2(dot(view.right, world), dot(view.up, world)) * view.scale;
    float ahead = dot(view.forward, world);
    out_uv = vec4(uv0, uv1);
    out_color = color;
    out_instance = gl_InstanceIndex;
    if (view.far > 0.0) {
        gl_Position = vec4(across, (view.far - ahead) / (view.far - view.near), 1.0);
    } else {
        gl_Position = vec4(across, view.near, ahead);
    }
}
