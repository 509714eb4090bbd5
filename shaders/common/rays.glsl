// Where a ray first meets the scene: what the rasteriser would draw, front faces unless double-sided, and not what is
// cut out. One question, `intersect`, and two ways to answer it: the device's own ray queries (RAY_QUERY defined) or our
// BVH. Both give the triangle's place in `triangle_rows`, so that what follows cannot tell them apart.
// Needs `triangle_rows` (usampler2D: TriangleData, sixteen bytes a texel), HAS_MASK and
// `bool uncut(uint triangle, vec2 uv)` from the includer.
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

bool uncut(uint triangle, vec2 uv);

#ifdef RAY_QUERY
#include "ray_query.glsl"
#else
#include "bvh.glsl"
#endif

#endif
