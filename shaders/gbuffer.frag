#version 460
// In: interpolated vertices, the material's textures. Out: packed surface, instance id + 1, and with EMISSION emission.
// The G-buffer of the paper's §3.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(constant_id = 0) const uint HAS_MASK = 1u;

layout(set = 0, binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(set = 0, binding = 2, std430) readonly buffer Materials { MaterialData materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D normal_texture;
layout(set = 1, binding = 3) uniform sampler2D emissive_texture;
layout(push_constant) uniform Constants { uint eye; };

#include "common/material.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent;
layout(location = 3) in vec4 uv;
layout(location = 4) in vec4 color;
layout(location = 5) flat in uint instance;

layout(location = 0) out uvec4 out_surface;
layout(location = 1) out uint out_instance;
// Without an attachment for it, an output would be a warning of the validation layer.
#ifdef EMISSION
layout(location = 2) out vec4 out_emission;
#endif

void main() {
    uint m = instances[instance].material;
    Textured t = Textured(vec4(1.0), vec2(1.0), vec3(0.0, 0.0, 1.0), vec3(1.0));
    if (has_texture(m, 0u)) t.base_color = texture(base_color_texture, slot_uv(m, 0u, uv));
    if (has_texture(m, 1u)) {
        t.roughness_metallic = texture(metallic_roughness_texture, slot_uv(m, 1u, uv)).gb;
    }
    if (has_texture(m, 2u)) t.normal = texture(normal_texture, slot_uv(m, 2u, uv)).xyz * 2.0 - 1.0;
#ifdef EMISSION
    if (has_texture(m, 3u)) t.emissive = texture(emissive_texture, slot_uv(m, 3u, uv)).rgb;
#endif
    t.base_color *= color;
    vec3 face = cross(dFdx(position), dFdy(position));
    if (HAS_MASK != 0u && materials[m].base_color.a * t.base_color.a < materials[m].alpha_cutoff) discard;
    vec3 v = normalize(frame.eyes[eye].position_near.xyz - position);
    face = normalize_or(face, v);
    if (dot(face, v) < 0.0) face = -face;
    out_surface = pack_surface(make_surface(m, t, normal, tangent, face, v));
    out_instance = instance + 1u;
#ifdef EMISSION
    out_emission = vec4(min(materials[m].emissive * t.emissive, vec3(65504.0)), 1.0);
#endif
}
