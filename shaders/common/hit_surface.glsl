// The surface that a ray of the reference hits: attributes, textures from a storage buffer (a shader here cannot
// index an array of images), then the same material as the G-buffer's.
// Needs triangles, instances, materials, textures, texels, vertices (float words), indices from the includer.
#ifndef HIT_SURFACE_GLSL
#define HIT_SURFACE_GLSL
#include "bvh.glsl"
#include "material.glsl"

// Set where a mirrored instance exchanged the triangle's second and third corner.
const uint EXCHANGED = 0x80000000u;

int wrap(int i, int n, uint mode) {
    if (mode == 2u) return clamp(i, 0, n - 1);
    int period = mode == 1u ? 2 * n : n;
    int k = i % period;
    if (k < 0) k += period;
    return k < n ? k : period - 1 - k;
}

vec4 texel(TextureData t, int x, int y) {
    x = wrap(x, int(t.width), t.flags & 3u);
    y = wrap(y, int(t.height), t.flags >> 2 & 3u);
    vec4 c = unpackUnorm4x8(texels[t.offset + uint(y) * t.width + uint(x)]);
    if ((t.flags & 16u) != 0u) {
        c.rgb = mix(pow((c.rgb + 0.055) / 1.055, vec3(2.4)), c.rgb / 12.92, lessThanEqual(c.rgb, vec3(0.04045)));
    }
    return c;
}

// Level 0, bilinear: the reference averages over its samples.
vec4 sample_texture(int index, vec2 uv) {
    TextureData t = textures[index];
    // Far outside the first period a float has no fraction left.
    vec2 p = clamp(uv, vec2(-1e4), vec2(1e4)) * vec2(t.width, t.height);
    if ((t.flags & 32u) != 0u) return texel(t, int(floor(p.x)), int(floor(p.y)));
    p -= 0.5;
    vec2 base = floor(p), f = p - base;
    int x = int(base.x), y = int(base.y);
    return mix(mix(texel(t, x, y), texel(t, x + 1, y), f.x), mix(texel(t, x, y + 1), texel(t, x + 1, y + 1), f.x), f.y);
}

struct Corners {
    uint a, b, c;   // first words of the three vertices
    vec3 weights;
};

Corners corners(uint triangle, vec2 uv) {
    uint first = triangles[triangle].first_index;
    if ((first & EXCHANGED) != 0u) uv = uv.yx;
    first &= ~EXCHANGED;
    uint base = instances[triangles[triangle].instance].first_vertex;
    Corners k;
    k.a = (base + indices[first]) * VERTEX_WORDS;
    k.b = (base + indices[first + 1u]) * VERTEX_WORDS;
    k.c = (base + indices[first + 2u]) * VERTEX_WORDS;
    k.weights = vec3(1.0 - uv.x - uv.y, uv);
    return k;
}

float interpolate(Corners k, uint word) {
    return dot(k.weights, vec3(vertices[k.a + word], vertices[k.b + word], vertices[k.c + word]));
}

vec4 hit_uv(Corners k) { return vec4(interpolate(k, 10u), interpolate(k, 11u), interpolate(k, 12u), interpolate(k, 13u)); }

vec4 hit_color(Corners k) {
    return mat3x4(unpackUnorm4x8(floatBitsToUint(vertices[k.a + 14u])), unpackUnorm4x8(floatBitsToUint(vertices[k.b + 14u])),
                  unpackUnorm4x8(floatBitsToUint(vertices[k.c + 14u]))) * k.weights;
}

// What the rasteriser would draw: front faces unless double-sided, and not what is cut out.
bool accept(uint triangle, vec2 uv, bool front) {
    uint index = instances[triangles[triangle].instance].material;
    if (!front && materials[index].double_sided == 0u) return false;
    float cutoff = materials[index].alpha_cutoff;
    if (HAS_MASK == 0u || cutoff < 0.0) return true;
    Corners k = corners(triangle, uv);
    float alpha = materials[index].base_color.a * hit_color(k).a;
    TextureSlot slot = materials[index].slots[0];
    if (slot.texture_index >= 0) alpha *= sample_texture(slot.texture_index, slot_uv(slot, hit_uv(k))).a;
    return alpha >= cutoff;
}

// `v` points back along the ray.
Surface hit_surface(Intersection hit, vec3 v, out vec3 emission) {
    TriangleData t = triangles[hit.triangle];
    MaterialData m = materials[instances[t.instance].material];
    Corners k = corners(hit.triangle, hit.uv);
    vec4 uv = hit_uv(k);
    Textured x = Textured(hit_color(k), vec2(1.0), vec3(0.0, 0.0, 1.0), vec3(1.0));
    if (m.slots[0].texture_index >= 0) x.base_color *= sample_texture(m.slots[0].texture_index, slot_uv(m.slots[0], uv));
    if (m.slots[1].texture_index >= 0) {
        x.roughness_metallic = sample_texture(m.slots[1].texture_index, slot_uv(m.slots[1], uv)).gb;
    }
    if (m.slots[2].texture_index >= 0) {
        x.normal = sample_texture(m.slots[2].texture_index, slot_uv(m.slots[2], uv)).xyz * 2.0 - 1.0;
    }
    if (m.slots[3].texture_index >= 0) x.emissive = sample_texture(m.slots[3].texture_index, slot_uv(m.slots[3], uv)).rgb;
    emission = min(m.emissive * x.emissive, vec3(65504.0));
    vec3 n = vec3(interpolate(k, 3u), interpolate(k, 4u), interpolate(k, 5u));
    vec3 tangent = vec3(interpolate(k, 6u), interpolate(k, 7u), interpolate(k, 8u));
    InstanceData i = instances[t.instance];
    vec3 normal = vec3(dot(i.normal_matrix[0].xyz, n), dot(i.normal_matrix[1].xyz, n), dot(i.normal_matrix[2].xyz, n));
    vec4 world_tangent = vec4(dot(i.render_from_object[0].xyz, tangent), dot(i.render_from_object[1].xyz, tangent),
                              dot(i.render_from_object[2].xyz, tangent), vertices[k.a + 9u]);
    vec3 face = normalize_or(cross(t.edge1, t.edge2), v);
    if (dot(face, v) < 0.0) face = -face;
    // Through the G-buffer's precision, so that the reference sees the surface that screen space sees.
    return unpack_surface(pack_surface(make_surface(m, x, normal, world_tangent, face, v)));
}

#endif
