// Nearest intersection in a binary BVH held in textures: the way of a device without ray queries. Needs `node_rows`
// (usampler2D: NodeData, sixteen bytes a texel) from the includer and what rays.glsl declares.
// Textures, not storage buffers: gathering from a buffer lane by lane makes a software device four times slower.
// Sources: Möller & Trumbore 1997; slab test with the direction's inverse.
#ifndef BVH_GLSL
#define BVH_GLSL

const int STACK_SIZE = 96;
// A leaf that does not exist.
const uint FINISHED = 0xffffffffu;

float enter(vec3 lower, vec3 upper, vec3 origin, vec3 inverse, float t_max) {
    vec3 a = (lower - origin) * inverse, b = (upper - origin) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float t0 = max(max(near.x, near.y), max(near.z, 0.0));
    // The exit a few ulps later, so that no box is missed by rounding (Ize 2013).
    float t1 = min(min(far.x, far.y), min(far.z, t_max)) * 1.0000004;
    return t0 <= t1 ? t0 : FLT_MAX;
}

Intersection intersect(vec3 origin, vec3 direction) {
    Intersection best = Intersection(FLT_MAX, vec2(0.0), NO_TRIANGLE);
    vec3 inverse = vec3(abs(direction.x) > 1e-20 ? 1.0 / direction.x : (direction.x < 0.0 ? -1e20 : 1e20),
                        abs(direction.y) > 1e-20 ? 1.0 / direction.y : (direction.y < 0.0 ? -1e20 : 1e20),
                        abs(direction.z) > 1e-20 ? 1.0 / direction.z : (direction.z < 0.0 ? -1e20 : 1e20));
    uint stack[STACK_SIZE];
    int top = 0;
    uint at = 0u;
    // Inner nodes until every lane has a leaf, then the leaves: lanes that share an instruction stream stay together.
    while (true) {
        while ((at & LEAF) == 0u) {
            vec4 l0 = row(node_rows, 4u * at), u0 = row(node_rows, 4u * at + 1u);
            vec4 l1 = row(node_rows, 4u * at + 2u), u1 = row(node_rows, 4u * at + 3u);
            float ta = enter(l0.xyz, u0.xyz, origin, inverse, best.t);
            float tb = enter(l1.xyz, u1.xyz, origin, inverse, best.t);
            uint a = floatBitsToUint(l0.w), b = floatBitsToUint(l1.w);
            uint near = tb < ta ? b : a, far = tb < ta ? a : b;
            if (max(ta, tb) < FLT_MAX && top < STACK_SIZE) stack[top++] = far;
            if (min(ta, tb) < FLT_MAX) {
                at = near;
            } else {
                at = top > 0 ? stack[--top] : FINISHED;
            }
        }
        if (at == FINISHED) return best;
        uint first = at & ((1u << COUNT_SHIFT) - 1u);
        uint end = first + (at >> COUNT_SHIFT & 7u) + 1u;
        for (uint i = first; i < end; ++i) {
            vec4 v0 = row(triangle_rows, 3u * i), w1 = row(triangle_rows, 3u * i + 1u), w2 = row(triangle_rows, 3u * i + 2u);
            vec3 e1 = w1.xyz, e2 = w2.xyz;
            vec3 p = cross(direction, e2);
            float det = dot(e1, p);
            float inv = 1.0 / det;
            vec3 s = origin - v0.xyz;
            float u = dot(s, p) * inv;
            vec3 q = cross(s, e1);
            float v = dot(direction, q) * inv;
            float t = dot(e2, q) * inv;
            // A degenerate triangle's NaN fails every comparison.
            if (!(u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < best.t)) continue;
            uint flags = floatBitsToUint(w2.w);
            if (det <= 0.0 && (flags & DOUBLE_SIDED) == 0u) continue;
            if (HAS_MASK != 0u && (flags & MASKED) != 0u && !uncut(i, vec2(u, v))) continue;
            best = Intersection(t, vec2(u, v), i);
        }
        at = top > 0 ? stack[--top] : FINISHED;
    }
    return best;
}

#endif
