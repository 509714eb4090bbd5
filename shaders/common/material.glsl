// Makes a surface from a material and its texture values, for the G-buffer as for hits of rays.
// Needs `materials` from the includer. Fields are read where they are used, because a copy of the structure costs more.
#ifndef MATERIAL_GLSL
#define MATERIAL_GLSL
#include "shared.glsl"
#include "surface.glsl"

bool has_texture(uint material, uint slot) { return materials[material].slots[slot].texture_index >= 0; }

vec2 slot_uv(uint material, uint slot, vec4 uv) {
    vec3 p = vec3(materials[material].slots[slot].uv_set == 0u ? uv.xy : uv.zw, 1.0);
    return vec2(dot(materials[material].slots[slot].row_u.xyz, p), dot(materials[material].slots[slot].row_v.xyz, p));
}

// Bends a normal to the viewer's side. A normal map may turn it away from the viewer, where reflection is undefined.
vec3 bend(vec3 n, vec3 v) {
    const float least = 0.01;
    float d = dot(n, v);
    return d >= least ? n : normalize_or(n + v * (least - d), v);
}

struct Textured {
    vec4 base_color;          // texture × vertex colour, linear; 1 without either
    vec2 roughness_metallic;  // 1 without a texture
    vec3 normal;              // tangent space; (0, 0, 1) without a texture
    vec3 emissive;            // 1 without a texture
};

// `normal` is the interpolated one. `face_normal` and both normals of the result are on v's side.
Surface make_surface(uint m, Textured t, vec3 normal, vec4 tangent, vec3 face_normal, vec3 v) {
    vec3 n = normalize_or(normal, face_normal);
    if (has_texture(m, 2u)) {
        vec3 x = normalize_or(tangent.xyz - n * dot(n, tangent.xyz), basis(n)[0]);
        vec3 y = cross(n, x) * tangent.w;
        vec3 local = vec3(t.normal.xy * materials[m].normal_scale, t.normal.z);
        n = normalize_or(x * local.x + y * local.y + n * local.z, n);
    }
    // The shading normal belongs to the side that is seen.
    if (dot(n, face_normal) < 0.0) n = -n;
    float metallic = clamp(materials[m].metallic * t.roughness_metallic.y, 0.0, 1.0);
    vec3 base = materials[m].base_color.rgb * t.base_color.rgb;
    Surface s;
    s.normal = bend(n, v);
    s.face_normal = face_normal;
    // Light that the surface transmits is lost to the picture, because a pixel shows only one surface.
    s.albedo = base * (1.0 - metallic) * (1.0 - materials[m].transmission);
    s.f0 = mix(materials[m].dielectric_f0, base, metallic);
    s.roughness = clamp(materials[m].roughness * t.roughness_metallic.x, 0.0, 1.0);
    return s;
}

#endif
