// Rays through the scene's geometry.
// `intersect`: the nearest triangle that a ray meets, among those that the rasteriser would draw: front faces, both faces of
// double-sided triangles, and nothing that is cut out. With TWO_SIDED defined it finds the backs of single-sided triangles too.
// `transmittance`: the share of a light that gets through all that lies on the way. Both sides of a surface stop light, so
// that a wall whose back the camera looks through still casts its shadow.
// Both functions exist twice: by the device's own ray queries (RAY_QUERY defined) and by our BVH. Both give the triangle's
// index in `triangle_rows`, so that the code that shades a hit is the same.
// Needs `triangle_rows` (usampler2D: TriangleData, sixteen bytes a texel), HAS_MASK, HAS_GLASS (some material transmits)
// and `uncut` and `let_through` from the includer.
#ifndef RAYS_GLSL
#define RAYS_GLSL
#include "math.glsl"

const uint NO_TRIANGLE = 0xffffffffu;

struct Intersection {
    float t;
    vec2 uv;         // weights of the second and third corner
    uint triangle;   // NO_TRIANGLE: the ray met nothing
};

// Twin: ROW_WIDTH in bvh.rs.
vec4 row(usampler2D rows, uint i) { return uintBitsToFloat(texelFetch(rows, ivec2(i & 4095u, i >> 12), 0)); }

// Whether a ray along `direction` meets the triangle's back.
bool sees_back(uint triangle, vec3 direction) {
    vec3 e1 = row(triangle_rows, 3u * triangle + 1u).xyz, e2 = row(triangle_rows, 3u * triangle + 2u).xyz;
    return dot(cross(e1, e2), direction) > 0.0;
}

// Whether a triangle of a cut-out material exists at a point.
bool uncut(uint triangle, vec2 uv);
// The share of light that a transmitting triangle lets through.
vec3 let_through(uint triangle, vec2 uv);

#ifdef RAY_QUERY
#include "ray_query.glsl"
#else
#include "bvh.glsl"
#endif

#endif
