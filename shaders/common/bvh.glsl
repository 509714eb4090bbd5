// `intersect` and `transmittance` of rays.glsl in a binary BVH, for devices without ray queries. Needs `node_rows`
// (usampler2D: NodeData, sixteen bytes a texel) from the includer, and what rays.glsl declares.
// The BVH lies in textures, not in storage buffers, because reading a buffer lane by lane makes a software device four times
// slower.
// Sources: Möller & Trumbore 1997; slab test with the direction's inverse.
#ifndef BVH_GLSL
#define BVH_GLSL

const int STACK_SIZE = 96;
// Stands for a leaf when no node is left to visit.
const uint FINISHED = 0xffffffffu;

// The nodes that the current ray has yet to visit. They are globals of the invocation, because passing a stack from function
// to function would copy it. An invocation follows one ray at a time.
uint stack[STACK_SIZE];
int stack_top;

float enter(vec3 lower, vec3 upper, vec3 origin, vec3 inverse, float t_max) {
    vec3 a = (lower - origin) * inverse, b = (upper - origin) * inverse;
    vec3 near = min(a, b), far = max(a, b);
    float t0 = max(max(near.x, near.y), max(near.z, 0.0));
    // The exit is moved a few ulps back, so that rounding never misses a box (Ize 2013).
    float t1 = min(min(far.x, far.y), min(far.z, t_max)) * 1.0000004;
    return t0 <= t1 ? t0 : FLT_MAX;
}

vec3 inverse_of(vec3 direction) {
    return vec3(abs(direction.x) > 1e-20 ? 1.0 / direction.x : (direction.x < 0.0 ? -1e20 : 1e20),
                abs(direction.y) > 1e-20 ? 1.0 / direction.y : (direction.y < 0.0 ? -1e20 : 1e20),
                abs(direction.z) > 1e-20 ? 1.0 / direction.z : (direction.z < 0.0 ? -1e20 : 1e20));
}

uint next_of_stack() {
    return stack_top > 0 ? stack[--stack_top] : FINISHED;
}

// The next leaf, from a node downwards, whose box the ray enters before t_max; FINISHED when there is none. Lanes that share
// an instruction stream diverge less when all of them first look for a leaf and then test its triangles.
uint next_leaf(uint at, vec3 origin, vec3 inverse, float t_max) {
    while ((at & LEAF) == 0u) {
        vec4 l0 = row(node_rows, 4u * at), u0 = row(node_rows, 4u * at + 1u);
        vec4 l1 = row(node_rows, 4u * at + 2u), u1 = row(node_rows, 4u * at + 3u);
        float ta = enter(l0.xyz, u0.xyz, origin, inverse, t_max);
        float tb = enter(l1.xyz, u1.xyz, origin, inverse, t_max);
        uint a = floatBitsToUint(l0.w), b = floatBitsToUint(l1.w);
        uint near = tb < ta ? b : a, far = tb < ta ? a : b;
        if (max(ta, tb) < FLT_MAX && stack_top < STACK_SIZE) stack[stack_top++] = far;
        at = min(ta, tb) < FLT_MAX ? near : next_of_stack();
    }
    return at;
}

// The triangles of a leaf: the index of the first one, and one more than the index of the last one.
uvec2 triangles_of(uint leaf) {
    uint first = leaf & ((1u << COUNT_SHIFT) - 1u);
    return uvec2(first, first + (leaf >> COUNT_SHIFT & 7u) + 1u);
}

// Where a ray meets a triangle.
struct Meeting {
    float t;
    vec2 uv;
    float facing;    // above 0: the front
    uint flags;
};

// False if the ray does not meet the triangle before t_max.
bool meets(uint triangle, vec3 origin, vec3 direction, float t_max, out Meeting m) {
    vec4 v0 = row(triangle_rows, 3u * triangle), w1 = row(triangle_rows, 3u * triangle + 1u);
    vec4 w2 = row(triangle_rows, 3u * triangle + 2u);
    vec3 e1 = w1.xyz, e2 = w2.xyz;
    vec3 p = cross(direction, e2);
    m.facing = dot(e1, p);
    float inv = 1.0 / m.facing;
    vec3 s = origin - v0.xyz;
    m.uv.x = dot(s, p) * inv;
    vec3 q = cross(s, e1);
    m.uv.y = dot(direction, q) * inv;
    m.t = dot(e2, q) * inv;
    m.flags = floatBitsToUint(w2.w);
    // A degenerate triangle's NaN fails every comparison.
    return m.uv.x >= 0.0 && m.uv.y >= 0.0 && m.uv.x + m.uv.y <= 1.0 && m.t > 0.0 && m.t < t_max;
}

Intersection intersect(vec3 origin, vec3 direction) {
    Intersection best = Intersection(FLT_MAX, vec2(0.0), NO_TRIANGLE);
    vec3 inverse = inverse_of(direction);
    stack_top = 0;
    uint leaf = next_leaf(0u, origin, inverse, best.t);
    while (leaf != FINISHED) {
        uvec2 triangles = triangles_of(leaf);
        for (uint i = triangles.x; i < triangles.y; ++i) {
            Meeting m;
            if (!meets(i, origin, direction, best.t, m)) continue;
#ifndef TWO_SIDED
            if (m.facing <= 0.0 && (m.flags & DOUBLE_SIDED) == 0u) continue;
#endif
            if (HAS_MASK != 0u && (m.flags & MASKED) != 0u && !uncut(i, m.uv)) continue;
            best = Intersection(m.t, m.uv, i);
        }
        leaf = next_leaf(next_of_stack(), origin, inverse, best.t);
    }
    return best;
}

vec3 transmittance(vec3 origin, vec3 direction, float t_max) {
    vec3 share = vec3(1.0);
    vec3 inverse = inverse_of(direction);
    stack_top = 0;
    uint leaf = next_leaf(0u, origin, inverse, t_max);
    while (leaf != FINISHED) {
        uvec2 triangles = triangles_of(leaf);
        for (uint i = triangles.x; i < triangles.y; ++i) {
            Meeting m;
            if (!meets(i, origin, direction, t_max, m)) continue;
            if (HAS_MASK != 0u && (m.flags & MASKED) != 0u && !uncut(i, m.uv)) continue;
            if (HAS_GLASS == 0u || (m.flags & TRANSMITS) == 0u) return vec3(0.0);
            share *= let_through(i, m.uv);
        }
        leaf = next_leaf(next_of_stack(), origin, inverse, t_max);
    }
    return share;
}

#endif
