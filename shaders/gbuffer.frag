#version 460
// In: interpolated vertices, the material's textures. Out: packed surface, instance id + 1, emission (when any).
// The G-buffer of the paper's §3.
#extension GL_GOOGLE_include_directive : require
#include "common/material.glsl"

layout(constant_id = 0) const uint HAS_EMISSION = 1u;
layout(constant_id = 1) const uint HAS_MASK = 1u;

layout(set = 0, binding = 0, std430) readonly buffer Frames { FrameUniform frame; };
layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(set = 0, binding = 2, std430) readonly buffer Materials { MaterialData materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D normal_texture;
layout(set = 1, binding = 3) uniform sampler2D emissive_texture;
layout(push_constant) uniform Constants { uint eye; };

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec4 uv;
layout(location = 4) in vec4 color;
layout(location = 5) flat in uint instance;

layout(location = 0) out uvec4 out_surface;
layout(location = 1) out uint out_instance;
layout(location = 2) out vec4 out_emission;

void main() {
    uint index = instances[instance].material;
    // Field by field: a copy of the whole structure costs more than what is used of it.
    MaterialData m = materials[index];
    Textured t = Textured(vec4(1.0), vec2(1.0), vec3(0.0, 0.0, 1.0), vec3(1.0));
    if (m.slots[0].texture_index >= 0) t.base_color = texture(base_color_texture, slot_uv(m.slots[0], uv));
    if (m.slots[1].texture_index >= 0) {
        t.roughness_metallic = texture(metallic_roughness_texture, slot_uv(m.slots[1], uv)).gb;
    }
    if (m.slots[2].texture_index >= 0) t.normal = texture(normal_texture, slot_uv(m.slots[2], uv)).xyz * 2.0 - 1.0;
    if (HAS_EMISSION != 0u && m.slots[3].texture_index >= 0) {
        t.emissive = texture(emissive_texture, slot_uv(m.slots[3], uv)).rgb;
    }
    t.base_color *= color;
    vec3 face = cross(dFdx(position), dFdy(position));
    if (HAS_MASK != 0u && m.base_color.a * t.base_color.a < m.alpha_cutoff) discard;
    vec3 v = normalize(frame.eyes[eye].position_near.xyz - position);
    face = normalize_or(face, v);
    if (dot(face, v) < 0.0) face = -face;
    out_surface = pack_surface(make_surface(m, t, normal, tangent, face, v));
    out_instance = instance + 1u;
    if (HAS_EMISSION != 0u) out_emission = vec4(min(m.emissive * t.emissive, vec3(65504.0)), 1.0);
}
