#version 460
// In: interpolated texture coordinates and colour, the material's base colour. Out: depth, except where a material is cut out,
// and except for the share of texels that a transmitting material leaves open.
// Screen-door transparency by ordered dither (Bayer 1973): the open share of 4×4 texels is the share of light that gets through.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(constant_id = 0) const uint HAS_MASK = 1u;
layout(constant_id = 1) const uint HAS_GLASS = 1u;

layout(set = 0, binding = 1, std430) readonly buffer Instances { InstanceData instances[]; };
layout(set = 0, binding = 2, std430) readonly buffer Materials { MaterialData materials[]; };
layout(set = 1, binding = 0) uniform sampler2D base_color_texture;

#include "common/material.glsl"

layout(location = 0) in vec4 uv;
layout(location = 1) in vec4 color;
layout(location = 2) flat in uint instance;

// The dither's thresholds: 1/32 to 31/32, each once in 4×4 texels.
float threshold(uvec2 texel) {
    uint a = texel.x ^ texel.y;
    uint rank = (a & 1u) << 3 | (texel.y & 1u) << 2 | (a & 2u) | (texel.y & 2u) >> 1;
    return (float(rank) + 0.5) / 16.0;
}

void main() {
    if (HAS_MASK + HAS_GLASS == 0u) return;
    uint m = instances[instance].material;
    vec4 base = materials[m].base_color * color;
    if (has_texture(m, 0u)) base *= texture(base_color_texture, slot_uv(m, 0u, uv));
    if (HAS_MASK != 0u && base.a < materials[m].alpha_cutoff) discard;
    if (HAS_GLASS != 0u && materials[m].transmission > 0.0) {
        // Light crosses a closed mesh twice, but the material's transmission stands for both sides: only front faces are drawn.
        if (instances[instance].closed != 0u && !gl_FrontFacing) discard;
        float share = clamp(materials[m].transmission * luminance(base.rgb), 0.0, 1.0);
        // The dither is shifted for each instance, so that an instance behind another one stops its share of the remaining light.
        uvec2 shift = uvec2(instance * 0x9e3779b9u >> 30, instance * 0x85ebca6bu >> 30);
        if (threshold(uvec2(gl_FragCoord.xy) + shift) < share) discard;
    }
}
