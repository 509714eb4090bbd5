// Nearest intersection in a binary BVH held in storage buffers. Needs `nodes` and `triangles`, and
// `bool accept(uint triangle, vec2 uv, bool front)` from the includer (cut-outs, single-sided surfaces).
// Sources: Möller & Trumbore 1997; slab test with the direction's inverse.
#ifndef BVH_GLSL
#define BVH_GLSL
#include "math.glsl"

const uint NO_TRIANGLE = 0xffffffffu;
const int STACK_SIZE = 96;

bool accept(uint triangle, vec2 uv, bool front);

struct Intersection {
    float t;
    vec2 uv;
    uint triangle;   // NO_TRIANGLE: a miss
    bool front;
};

float enter(vec3 lower, vec3 upper, vec3 origin, vec3 inverse, float t_max) {
    vec3 a = (lower - origin) * inverse, b = (upper - origin) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float t0 = max(max(near.x, near.y), max(near.z, 0.0));
    // The exit a few ulps later, so that no box is missed by rounding (Ize 2013).
    float t1 = min(min(far.x, far.y), min(far.z, t_max)) * 1.0000004;
    return t0 <= t1 ? t0 : FLT_MAX;
}

Intersection intersect(vec3 origin, vec3 direction) {
    Intersection best = Intersection(FLT_MAX, vec2(0.0), NO_TRIANGLE, true);
    vec3 inverse = vec3(abs(direction.x) > 1e-20 ? 1.0 / direction.x : (direction.x < 0.0 ? -1e20 : 1e20),
                        abs(direction.y) > 1e-20 ? 1.0 / direction.y : (direction.y < 0.0 ? -1e20 : 1e20),
                        abs(direction.z) > 1e-20 ? 1.0 / direction.z : (direction.z < 0.0 ? -1e20 : 1e20));
    uint stack[STACK_SIZE];
    int top = 0;
    uint at = 0u;
    if (enter(nodes[0].lower, nodes[0].upper, origin, inverse, best.t) == FLT_MAX) return best;
    while (true) {
        NodeData node = nodes[at];
        if (node.count > 0u) {
            for (uint i = node.first; i < node.first + node.count; ++i) {
                vec3 e1 = triangles[i].edge1, e2 = triangles[i].edge2;
                vec3 p = cross(direction, e2);
                float det = dot(e1, p);
                if (det == 0.0) continue;
                float inv = 1.0 / det;
                vec3 s = origin - triangles[i].v0;
                float u = dot(s, p) * inv;
                if (u < 0.0 || u > 1.0) continue;
                vec3 q = cross(s, e1);
                float v = dot(direction, q) * inv;
                if (v < 0.0 || u + v > 1.0) continue;
                float t = dot(e2, q) * inv;
                if (t <= 0.0 || t >= best.t) continue;
                if (!accept(i, vec2(u, v), det > 0.0)) continue;
                best = Intersection(t, vec2(u, v), i, det > 0.0);
            }
        } else {
            uint a = node.first, b = node.first + 1u;
            float ta = enter(nodes[a].lower, nodes[a].upper, origin, inverse, best.t);
            float tb = enter(nodes[b].lower, nodes[b].upper, origin, inverse, best.t);
            if (tb < ta) {
                uint k = a;
                a = b;
                b = k;
                float x = ta;
                ta = tb;
                tb = x;
            }
            if (ta < FLT_MAX) {
                if (tb < FLT_MAX && top < STACK_SIZE) stack[top++] = b;
                at = a;
                continue;
            }
        }
        if (top == 0) return best;
        at = stack[--top];
    }
    return best;
}

#endif
