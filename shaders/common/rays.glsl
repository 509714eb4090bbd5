// Where a ray first meets the scene: what the rasteriser would draw, front faces unless double-sided, and not what is
// cut out. And which share of a light arrives through what lies on the way: matter stops light from both its sides, so
// that a wall that is open to the camera still casts its shadow.
// Two questions, `intersect` and `transmittance`, and two ways to answer them: the device's own ray queries (RAY_QUERY
// defined) or our BVH. Both give the triangle's place in `triangle_rows`, so that what follows cannot tell them apart.
// With TWO_SIDED defined, `intersect` finds the backs of single-sided triangles too.
// Needs `triangle_rows` (usampler2D: TriangleData, sixteen bytes a texel), HAS_MASK, HAS_GLASS (some material transmits)
// and `uncut` and `let_through` from the includer.
#ifndef RAYS_GLSL
#define RAYS_GLSL
#include "math.glsl"

const uint NO_TRIANGLE = 0xffffffffu;

struct Intersection {
    float t;
    vec2 uv;         // weights of the second and third corner
    uint triangle;   // NO_TRIANGLE: a miss
};

// Twin: ROW_WIDTH in bvh.rs.
vec4 row(usampler2D rows, uint i) { return uintBitsToFloat(texelFetch(rows, ivec2(i & 4095u, i >> 12), 0)); }

// Whether a ray along `direction` meets the triangle's back.
bool sees_back(uint triangle, vec3 direction) {
    vec3 e1 = row(triangle_rows, 3u * triangle + 1u).xyz, e2 = row(triangle_rows, 3u * triangle + 2u).xyz;
    return dot(cross(e1, e2), direction) > 0.0;
}

bool uncut(uint triangle, vec2 uv);
// The share of light that goes through a surface.
vec3 let_through(uint triangle, vec2 uv);

#ifdef RAY_QUERY
#include "ray_query.glsl"
#else
#include "bvh.glsl"
#endif

#endif
