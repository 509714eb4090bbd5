// Baked light at a point of a triangle, as irradiance / π. It is interpolated linearly between the points of the triangle's
// own lattice (after Yuksel et al., "Mesh Colors", 2010). Twin: lattice.rs.
// Needs `patch_rows` and `light_rows` (usampler2D), rays.glsl and `instances`; EXCHANGED of hit_surface.glsl.
#ifndef BAKED_GLSL
#define BAKED_GLSL

// Four words a texel. The word at an instance's number is the index of the first of the instance's patches.
uint patch_word(uint i) { return texelFetch(patch_rows, ivec2(i >> 2 & 4095u, i >> 14), 0)[i & 3u]; }

// Row j of a lattice of n intervals a side holds n + 1 − j points.
uint lattice_point(uint n, uint i, uint j) { return j * (n + 1u) - (j * j - j) / 2u + i; }

// `back`: the triangle is seen from its back.
vec3 baked_light(uint triangle, vec2 uv, bool back) {
    uint instance = floatBitsToUint(row(triangle_rows, 3u * triangle).w);
    uint first = floatBitsToUint(row(triangle_rows, 3u * triangle + 1u).w);
    if ((first & EXCHANGED) != 0u) uv = uv.yx;
    uint word = patch_word(patch_word(instance) + ((first & ~EXCHANGED) - instances[instance].first_index) / 3u);
    uint n = word >> 26, base = word & 0x1ffffffu;
    if (back && (word >> 25 & 1u) != 0u) base += (n + 1u) * (n + 2u) / 2u;
    vec2 p = clamp(uv, 0.0, 1.0) * float(n);
    uint i = min(uint(p.x), n - 1u);
    uint j = min(uint(p.y), n - 1u - i);
    vec2 f = clamp(p - vec2(i, j), 0.0, 1.0);
    vec3 right = row(light_rows, base + lattice_point(n, i + 1u, j)).rgb;
    vec3 up = row(light_rows, base + lattice_point(n, i, j + 1u)).rgb;
    if (f.x + f.y > 1.0 && i + j + 2u <= n) {
        vec3 far = row(light_rows, base + lattice_point(n, i + 1u, j + 1u)).rgb;
        return far * (f.x + f.y - 1.0) + right * (1.0 - f.y) + up * (1.0 - f.x);
    }
    vec3 near = row(light_rows, base + lattice_point(n, i, j)).rgb;
    float sum = max(f.x + f.y, 1.0);
    return near * (1.0 - (f.x + f.y) / sum) + (right * f.x + up * f.y) / sum;
}

#endif
