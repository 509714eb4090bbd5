// The surface that a ray hits in the scene's geometry: interpolated vertex attributes, textures, and the same material code
// as the G-buffer's. The textures lie in a storage buffer, because these shaders cannot index an array of images.
// Needs triangles, instances, materials, textures, texels, vertices (float words), indices from the includer.
#ifndef HIT_SURFACE_GLSL
#define HIT_SURFACE_GLSL
#include "rays.glsl"
#include "material.glsl"

// Flag of a triangle whose second and third corner were exchanged, because its instance is mirrored.
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

// Bilinear at mip level 0 only: the reference's average over its samples filters the texture.
vec4 sample_texture(int index, vec2 uv) {
    TextureData t = textures[index];
    // The clamp is there because a float far outside the first period has no fraction left.
    vec2 p = clamp(uv, vec2(-1e4), vec2(1e4)) * vec2(t.width, t.height);
    if ((t.flags & 32u) != 0u) return texel(t, int(floor(p.x)), int(floor(p.y)));
    p -= 0.5;
    vec2 base = floor(p), f = p - base;
    int x = int(base.x), y = int(base.y);
    return mix(mix(texel(t, x, y), texel(t, x + 1, y), f.x), mix(texel(t, x, y + 1), texel(t, x + 1, y + 1), f.x), f.y);
}

vec4 hit_texture(uint material, uint slot, vec4 uv) {
    return sample_texture(materials[material].slots[slot].texture_index, slot_uv(material, slot, uv));
}

struct Corners {
    uint a, b, c;   // first words of the three vertices
    vec3 weights;
};

Corners corners(uint triangle, vec2 uv) {
    uint first = floatBitsToUint(row(triangle_rows, 3u * triangle + 1u).w);
    if ((first & EXCHANGED) != 0u) uv = uv.yx;
    first &= ~EXCHANGED;
    uint base = instances[floatBitsToUint(row(triangle_rows, 3u * triangle).w)].first_vertex;
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

bool uncut(uint triangle, vec2 uv) {
    uint m = instances[floatBitsToUint(row(triangle_rows, 3u * triangle).w)].material;
    Corners k = corners(triangle, uv);
    float alpha = materials[m].base_color.a * hit_color(k).a;
    if (has_texture(m, 0u)) alpha *= hit_texture(m, 0u, hit_uv(k)).a;
    return alpha >= materials[m].alpha_cutoff;
}

// The material's transmission times its base colour. Light crosses a closed mesh twice, so that each side takes the square
// root.
vec3 let_through(uint triangle, vec2 uv) {
    uint instance = floatBitsToUint(row(triangle_rows, 3u * triangle).w);
    uint m = instances[instance].material;
    Corners k = corners(triangle, uv);
    vec3 color = materials[m].base_color.rgb * hit_color(k).rgb;
    if (has_texture(m, 0u)) color *= hit_texture(m, 0u, hit_uv(k)).rgb;
    vec3 share = clamp(materials[m].transmission * color, 0.0, 1.0);
    return instances[instance].closed != 0u ? sqrt(share) : share;
}

// `v` points back along the ray.
Surface hit_surface(Intersection hit, vec3 v, out vec3 emission) {
    uint instance = floatBitsToUint(row(triangle_rows, 3u * hit.triangle).w);
    uint m = instances[instance].material;
    Corners k = corners(hit.triangle, hit.uv);
    vec4 uv = hit_uv(k);
    Textured x = Textured(hit_color(k), vec2(1.0), vec3(0.0, 0.0, 1.0), vec3(1.0));
    if (has_texture(m, 0u)) x.base_color *= hit_texture(m, 0u, uv);
    if (has_texture(m, 1u)) x.roughness_metallic = hit_texture(m, 1u, uv).gb;
    if (has_texture(m, 2u)) x.normal = hit_texture(m, 2u, uv).xyz * 2.0 - 1.0;
    if (has_texture(m, 3u)) x.emissive = hit_texture(m, 3u, uv).rgb;
    emission = min(materials[m].emissive * x.emissive, vec3(65504.0));
    vec3 n = vec3(interpolate(k, 3u), interpolate(k, 4u), interpolate(k, 5u));
    vec3 normal = vec3(dot(instances[instance].normal_matrix[0].xyz, n), dot(instances[instance].normal_matrix[1].xyz, n),
                       dot(instances[instance].normal_matrix[2].xyz, n));
    vec4 tangent = vec4(0.0);
    if (has_texture(m, 2u)) {
        vec3 t = vec3(interpolate(k, 6u), interpolate(k, 7u), interpolate(k, 8u));
        tangent = vec4(dot(instances[instance].render_from_object[0].xyz, t),
                       dot(instances[instance].render_from_object[1].xyz, t),
                       dot(instances[instance].render_from_object[2].xyz, t), vertices[k.a + 9u]);
    }
    vec3 face = normalize_or(cross(row(triangle_rows, 3u * hit.triangle + 1u).xyz, row(triangle_rows, 3u * hit.triangle + 2u).xyz), v);
    if (dot(face, v) < 0.0) face = -face;
    // Through the G-buffer's precision, so that the reference sees the surface that screen space sees.
    return unpack_surface(pack_surface(make_surface(m, x, normal, tangent, face, v)));
}

#endif
