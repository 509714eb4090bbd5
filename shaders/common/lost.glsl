// Rays that the views cannot answer and that may ask the scene's geometry (trace_geometry.comp).
// Needs `frame` from the includer, and after it random.glsl, reflect.glsl and hit.glsl.
//
// Near a view's border, where hits fade, a hit is kept with a probability equal to its confidence and otherwise counts as
// lost, so that the fade blends from the view to the geometry. Only a share of the lost rays asks the geometry. The others
// count as no ray, and the weights make up for them, so that the expected sum does not change.
#ifndef LOST_GLSL
#define LOST_GLSL

// The share of the lost rays that ask the geometry, in 255ths; 0: the method never asks it.
layout(constant_id = 4) const uint LOST_SHARE = 0u;

// Whether the ray must ask the geometry. If not, `hit` has its final status and confidence. skipped: the ray is lost and does
// not ask.
bool ask_geometry(ivec3 texel, uint sample_index, bool mirror, inout Hit hit, out bool skipped) {
    uint token = frame.eyes[texel.z].stream.x, seed = combine(frame.seed, frame.frame);
    uvec2 pixel = uvec2(texel.xy);
    skipped = false;
    bool lost = hit.status == UNKNOWN;
    if (hit.status == HIT) lost = draw_1d(seed, token, pixel, sample_index, DRAW_FADE) >= hit.confidence;
    // A mirror's only ray always asks, because no neighbour could make up for it.
    bool asks = mirror || LOST_SHARE == 255u ||
                lattice_1d(seed, token, pixel, sample_index, DRAW_ASK) < float(LOST_SHARE) * (1.0 / 255.0);
    if (lost && asks) return true;
    // Relative weights: a ray that asks has weight 1, one that the views answered has the share as its weight.
    float view_weight = mirror ? 1.0 : float(LOST_SHARE) * (1.0 / 255.0);
    hit.confidence = lost ? 0.0 : view_weight;
    if (hit.status == NOTHING || lost) hit.status = NOTHING;
    skipped = lost;
    return false;
}

#endif
