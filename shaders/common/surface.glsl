// The G-buffer's surface, packed in four words: normals in 2×16 bits (with 2×8 a reflection would be off by a degree), colours
// as square roots in 8 bits, roughness in 16.
#ifndef SURFACE_GLSL
#define SURFACE_GLSL
#include "math.glsl"

struct Surface {
    vec3 normal;            // shading normal, bent to the viewer's side
    vec3 face_normal;       // of the triangle, on the viewer's side
    vec3 albedo;            // of the diffuse part, linear
    vec3 f0;                // reflectance at normal incidence, linear
    float roughness;        // perceptual
};

uvec4 pack_surface(Surface s) {
    uint r = uint(clamp(s.roughness, 0.0, 1.0) * 65535.0 + 0.5);
    uint albedo = packUnorm4x8(vec4(sqrt(clamp(s.albedo, 0.0, 1.0)), 0.0)) & 0xffffffu;
    uint f0 = packUnorm4x8(vec4(sqrt(clamp(s.f0, 0.0, 1.0)), 0.0)) & 0xffffffu;
    return uvec4(pack_direction(s.normal), pack_direction(s.face_normal), albedo | (r & 0xffu) << 24, f0 | (r >> 8) << 24);
}

float unpack_roughness(uvec4 p) { return float((p.z >> 24) | (p.w >> 24) << 8) * (1.0 / 65535.0); }

Surface unpack_surface(uvec4 p) {
    vec3 albedo = unpackUnorm4x8(p.z).rgb, f0 = unpackUnorm4x8(p.w).rgb;
    return Surface(unpack_direction(p.x), unpack_direction(p.y), albedo * albedo, f0 * f0, unpack_roughness(p));
}

#endif
