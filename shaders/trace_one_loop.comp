#version 460
// In: ray list, G-buffer, level 0 of the depth pyramid. Out: for each listed pixel how its reflection ray ended.
// The paper's §4.1 to the letter, against which trace.comp and trace_other_eye.comp are tested. One loop over world fractions
// looks at the ray in its own eye at every step, and in the other eye wherever its own eye does not see it. There is no
// hierarchy and there are no screen fractions: the borders of pixels are found in clip space, where the ray is linear for
// every eye.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 64) in;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4) uniform usampler2DArray surface_image;
layout(binding = 5) uniform sampler2DArray pyramid;
layout(binding = 6, rgba32ui) writeonly uniform uimage2DArray hit_image;
layout(push_constant) uniform Constants { uint sample_index; };

#include "common/ray_list.glsl"
#include "common/screen_ray.glsl"

// More than the number of pixels of both images on any line.
const uint MOST_STEPS = 65536u;

// The ray as an eye sees it.
struct Line {
    vec4 from;       // clip space, at world fractions 0 and 1
    vec4 delta;
    float near;
    float first;     // world fractions between which it is inside the view
    float last;
};

Line line_of(ScreenRay r, uint eye) {
    mat4 clip = frame.eyes[eye].clip_from_render;
    Line l;
    l.from = clip * vec4(r.origin, 1.0);
    l.delta = clip * vec4(r.ray.direction * frame.ray_length, 0.0);
    l.near = frame.eyes[eye].position_near.w;
    l.first = 0.0;
    l.last = 1.0;
    vec4 a = l.from, d = l.delta;
    float at[5] = float[5](a.w + a.x, a.w - a.x, a.w + a.y, a.w - a.y, a.w - l.near);
    float grows[5] = float[5](d.w + d.x, d.w - d.x, d.w + d.y, d.w - d.y, d.w);
    for (int i = 0; i < 5; ++i) {
        if (grows[i] > 0.0) l.first = max(l.first, -at[i] / grows[i]);
        else if (grows[i] < 0.0) l.last = min(l.last, -at[i] / grows[i]);
        else if (at[i] < 0.0) l.last = -1.0;
    }
    return l;
}

bool sees(Line l, float s) { return s >= l.first && s < l.last; }

const uint FRONT = 0u, INSIDE = 1u, BEHIND = 2u;

// The part of a line within one pixel, from a world fraction `s` on.
struct Cell {
    uint side;       // FRONT, INSIDE or BEHIND the pixel's matter
    ivec2 pixel;
    float leaves;    // world fraction where the line leaves the pixel
    float meets;     // world fraction of the hit, where INSIDE
};

Cell cell_at(Line l, uint eye, float s) {
    // As far beyond a border as the march of march.glsl steps.
    const float NUDGE = 1.0 / 256.0;
    vec4 c = l.from + s * l.delta;
    vec2 size = vec2(frame.size);
    vec2 at = (vec2(c.x, -c.y) / c.w * 0.5 + 0.5) * size;
    Cell cell;
    cell.pixel = clamp(ivec2(floor(at)), ivec2(0), ivec2(frame.size) - 1);
    vec2 from = vec2(l.from.x, -l.from.y), delta = vec2(l.delta.x, -l.delta.y);
    // Has the sign of the screen coordinate's derivative, which is the same all along the line.
    vec2 change = delta * l.from.w - from * l.delta.w;
    cell.leaves = l.last;
    for (int i = 0; i < 2; ++i) {
        if (change[i] == 0.0) continue;
        float border = change[i] > 0.0 ? float(cell.pixel[i] + 1) + NUDGE : float(cell.pixel[i]) - NUDGE;
        float ndc = border / size[i] * 2.0 - 1.0;
        float slope = delta[i] - ndc * l.delta.w;
        if (slope == 0.0) continue;
        float meets = (ndc * l.from.w - from[i]) / slope;
        if (meets > s) cell.leaves = min(cell.leaves, meets);
    }
    cell.leaves = max(cell.leaves, s + max(s, 1e-6) * 2e-7);
    float z0 = l.near / c.w, z1 = l.near / (l.from.w + min(cell.leaves, 1.0) * l.delta.w);
    vec2 range = load_range(cell.pixel, 0, eye);
    cell.side = min(z0, z1) > range.x ? FRONT : max(z0, z1) < range.y ? BEHIND : INSIDE;
    cell.meets = s;
    if (cell.side == INSIDE && z0 > range.x) {
        cell.meets = clamp((l.near / range.x - l.from.w) / l.delta.w, s, cell.leaves);
    }
    return cell;
}

uint walk(ScreenRay r, uint own, inout Hit hit, out uint steps) {
    uint other = 1u - own;
    Line mine = line_of(r, own), theirs = line_of(r, other);
    steps = 0u;
    if (!sees(mine, 0.0)) return TALLY_LEFT_VIEW;
    bool lost = false;
    // First step out of the pixel in which the ray starts.
    float s = cell_at(mine, own, 0.0).leaves;
    while (s < 1.0) {
        if (++steps > MOST_STEPS) return TALLY_BUDGET;
        bool here = sees(mine, s), there = sees(theirs, s);
        if (!here && !there) {
            if (s < mine.first) s = mine.first;
            else if (s < theirs.first && theirs.first < theirs.last) s = theirs.first;
            else return TALLY_LEFT_VIEW;
            // Neither eye saw what the ray passed on the way.
            lost = true;
            continue;
        }
        float next = 1.0;
        if (here) {
            Cell cell = cell_at(mine, own, s);
            next = cell.leaves;
            if (cell.side == FRONT) {
                s = next;
                continue;
            }
            if (cell.side == INSIDE) return found(r, ivec3(cell.pixel, own), cell.meets, hit);
        }
        if (there) {
            Cell cell = cell_at(theirs, other, s);
            if (cell.side == INSIDE) return found(r, ivec3(cell.pixel, other), cell.meets, hit);
            // The ray is behind matter for both eyes, and neither knows what is there.
            lost = lost || cell.side == BEHIND;
            next = min(next, cell.leaves);
        } else {
            lost = true;
        }
        s = next;
    }
    if (lost) return TALLY_BEHIND;
    hit.status = SKY;
    hit.confidence = 1.0;
    hit.distance = frame.ray_length;
    return TALLY_SKY;
}

void main() {
    ivec3 texel;
    if (!listed_pixel(texel)) return;
    uint eye = uint(texel.z);
    ScreenRay r = screen_ray(texel, sample_index);
    Hit hit = Hit(NOTHING, vec2(0.0), eye, r.ray.direction, 0.0, r.ray.pdf, 0.0);
    if (!r.ray.open) {
        atomicAdd(counters.below_horizon, 1u);
        hit.confidence = r.ray.above ? 1.0 : 0.0;
        imageStore(hit_image, texel, pack_hit(hit));
        return;
    }
    hit.status = UNKNOWN;
    uint steps;
    uint word = walk(r, eye, hit, steps);
    imageStore(hit_image, texel, pack_hit(hit));
    atomicAdd(counters.rays, 1u);
    // Steps are not counted: a thousand of them for each ray would overflow the counter in a large image.
    if (word == TALLY_HITS) atomicAdd(counters.hits, 1u);
    if (word == TALLY_SKY) atomicAdd(counters.sky, 1u);
    if (word == TALLY_LEFT_VIEW) atomicAdd(counters.left_view, 1u);
    if (word == TALLY_BEHIND) atomicAdd(counters.behind, 1u);
    if (word == TALLY_BACK_FACING) atomicAdd(counters.back_facing, 1u);
    if (word == TALLY_BUDGET) atomicAdd(counters.budget, 1u);
}
