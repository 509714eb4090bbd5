// Rays that the views cannot answer and that may ask the scene's geometry (trace_geometry.comp).
// Needs `frame` from the includer, and after it random.glsl, reflect.glsl and hit.glsl.
//
// Where a view's border fades, a hit is kept with the probability of its confidence and otherwise counts as lost, so
// that the fade leads from the view to the geometry. Of the lost rays a share asks; the others count as no ray, and
// those that ask carry their weight: the sum's mean does not change.
#ifndef LOST_GLSL
#define LOST_GLSL

// Of 255: how many of the lost rays ask; 0: the method never asks the geometry.
layout(constant_id = 4) const uint LOST_SHARE = 0u;

// Whether the geometry is to be asked instead of what the views said. Otherwise `hit` has its final confidence.
// skipped: lost, and not asked.
bool ask_geometry(ivec3 texel, uint sample_index, bool mirror, inout Hit hit, out bool skipped) {
    uint token = frame.eyes[texel.z].stream.x, seed = combine(frame.seed, frame.frame);
    uvec2 pixel = uvec2(texel.xy);
    skipped = false;
    bool lost = hit.status == UNKNOWN;
    if (hit.status == HIT) lost = draw_1d(seed, token, pixel, sample_index, DRAW_FADE) >= hit.confidence;
    // A mirror's one ray has no neighbours that could carry its weight.
    bool asks = mirror || LOST_SHARE == 255u ||
                lattice_1d(seed, token, pixel, sample_index, DRAW_ASK) < float(LOST_SHARE) * (1.0 / 255.0);
    if (lost && asks) return true;
    // Relative weights: what asked has 1, what the views answered has the share.
    float view_weight = mirror ? 1.0 : float(LOST_SHARE) * (1.0 / 255.0);
    hit.confidence = lost ? 0.0 : view_weight;
    if (hit.status == NOTHING || lost) hit.status = NOTHING;
    skipped = lost;
    return false;
}

#endif
