// The Hi-Z march of a ray through one eye's depth pyramid. It declares no bindings.
// The includer gives `vec2 load_range(ivec2 cell, int level, uint eye)`: nearest front and farthest back, raw reverse-Z.
// Sources: Uludag 2018 (hierarchy), McGuire & Mara 2014 (screen-space lines), the paper's §4.1 (dual depth).
#ifndef MARCH_GLSL
#define MARCH_GLSL
#include "math.glsl"

const int TOP_LEVEL = 6;

// Where a segment ends.
const uint END_FAR = 0u;     // at the ray's far end, inside the view
const uint END_SIDE = 1u;    // at a side of the view
const uint END_NEAR = 2u;    // at the near plane

struct Segment {
    vec3 start;      // pixels and raw depth
    vec3 delta;      // from the start to the end
    float w_start;   // clip-space w at both ends
    float w_end;
    float s_start;   // world fractions of the ray (0 to 1 of its length) at both ends
    float s_end;
    uint end;
    bool inside;     // the start lies inside the view
};

// The part of a ray, from world fraction `s_start` on, that lies in this eye's view. It is clipped in homogeneous space, before
// the division by w, because a ray towards the eye crosses w = 0. World fractions are linear in clip space. They therefore mean
// the same point for both eyes, whatever the frusta and orientations of the eyes; screen fractions do not.
// a, b: the ray's ends in clip space; near: the near plane's distance.
Segment clip_segment(vec4 a, vec4 b, float s_start, float near, vec2 size) {
    a = mix(a, b, s_start);
    float from[5] = float[5](a.w + a.x, a.w - a.x, a.w + a.y, a.w - a.y, a.w - near);
    float to[5] = float[5](b.w + b.x, b.w - b.x, b.w + b.y, b.w - b.y, b.w - near);
    Segment s;
    s.end = END_FAR;
    s.inside = true;
    float f_end = 1.0;
    for (int i = 0; i < 5; ++i) {
        s.inside = s.inside && from[i] >= 0.0;
        if (to[i] < 0.0) {
            float f = clamp(from[i] / (from[i] - to[i]), 0.0, 1.0);
            if (f < f_end) {
                f_end = f;
                s.end = i == 4 ? END_NEAR : END_SIDE;
            }
        }
    }
    vec4 c = mix(a, b, f_end);
    s.s_start = s_start;
    s.s_end = mix(s_start, 1.0, f_end);
    s.w_start = a.w;
    s.w_end = c.w;
    // Raw depth is exactly near/w.
    s.start = vec3((vec2(a.x, -a.y) / a.w * 0.5 + 0.5) * size, near / a.w);
    s.delta = vec3((vec2(c.x, -c.y) / c.w * 0.5 + 0.5) * size, near / c.w) - s.start;
    return s;
}

// World fraction of the ray at screen fraction t of its segment.
float world_fraction(Segment s, float t) {
    return mix(s.s_start, s.s_end, t * s.w_start / mix(s.w_end, s.w_start, t));
}

const uint MARCH_HIT = 0u;
const uint MARCH_END = 1u;      // reached the segment's end
const uint MARCH_BUDGET = 2u;   // ran out of steps: the ray is unknown
const uint MARCH_BEHIND = 3u;   // stopped where it went behind matter
const uint MARCH_FRONT = 4u;    // stopped where it came out from behind matter

struct March {
    uint result;
    float t;         // screen fraction
    bool behind;     // the march passed behind matter and went on
    uint steps;
    float gap;       // how far behind matter the march stopped, raw depth
};

// Where a march stops before it hits something or reaches its end.
const uint STOP_NEVER = 0u;    // nowhere: it also goes on behind matter
const uint STOP_BEHIND = 1u;   // where it goes behind matter
const uint STOP_FRONT = 2u;    // where it comes out from behind matter

// `leave`: first step out of the pixel in which the ray starts, because it starts on that pixel's surface. `gap`: with
// STOP_BEHIND the march stops only if it is at least this far behind matter, in raw depth, where it first goes behind it.
March march(Segment s, uint eye, uint max_steps, bool leave, uint stop, float gap) {
    // Each step goes this fraction of a cell beyond the boundary, so that it lands in the next cell.
    const float NUDGE = 1.0 / 256.0;
    March m = March(MARCH_END, 0.0, false, 0u, 0.0);
    vec2 d = s.delta.xy;
    vec2 inverse = vec2(abs(d.x) > 1e-12 ? 1.0 / d.x : FLT_MAX, abs(d.y) > 1e-12 ? 1.0 / d.y : FLT_MAX);
    vec2 side = vec2(d.x < 0.0 ? 0.0 : 1.0, d.y < 0.0 ? 0.0 : 1.0);
    vec2 nudge = vec2(d.x < 0.0 ? -NUDGE : NUDGE, d.y < 0.0 ? -NUDGE : NUDGE);
    // A ray that never leaves its own pixel has m.t ≥ 1 here, and the march ends at once.
    vec2 bounds = (floor(s.start.xy) + side + nudge - s.start.xy) * inverse;
    if (leave) m.t = max(min(bounds.x, bounds.y), 0.0);
    int level = 0;
    while (m.t < 1.0) {
        if (m.steps >= max_steps) {
            m.result = MARCH_BUDGET;
            return m;
        }
        ++m.steps;
        float scale = float(1 << level);
        ivec2 cell = max(ivec2(floor(s.start.xy + d * m.t)), ivec2(0)) >> level;
        vec2 range = load_range(cell, level, eye);
        bounds = ((vec2(cell) + side + nudge) * scale - s.start.xy) * inverse;
        // Rounding may put the boundary behind us; a step always goes forward.
        float t_exit = min(max(min(bounds.x, bounds.y), m.t + 1e-7), 1.0);
        float z0 = s.start.z + s.delta.z * m.t, z1 = s.start.z + s.delta.z * t_exit;
        bool front = min(z0, z1) > range.x;
        if (front || max(z0, z1) < range.y) {
            // The ray passes the cell in front of all its matter (`front`) or behind all of it.
            bool far = front || gap <= 0.0 || !m.behind && range.y - max(z0, z1) >= gap;
            if (stop == (front ? STOP_FRONT : STOP_BEHIND) && far) {
                m.result = front ? MARCH_FRONT : MARCH_BEHIND;
                m.gap = range.y - max(z0, z1);
                return m;
            }
            m.behind = m.behind || !front;
            m.t = t_exit;
            // Go up a level only when the ray leaves the parent cell. Inside it, the parent would only send the ray down again.
            ivec2 next = max(ivec2(floor(s.start.xy + d * m.t)), ivec2(0)) >> level;
            if (any(notEqual(next >> 1, cell >> 1))) level = min(level + 1, TOP_LEVEL);
        } else if (level > 0) {
            --level;
        } else {
            // At level 0 the ray is inside the matter of this pixel: a hit. A ray that comes from the front hits where its
            // depth equals the surface's.
            if (z0 > range.x) m.t = clamp((range.x - s.start.z) / s.delta.z, m.t, t_exit);
            m.result = MARCH_HIT;
            return m;
        }
    }
    m.t = 1.0;
    return m;
}

#endif
