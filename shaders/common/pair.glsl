// The pixel of the other eye that shows the same reflection (paper §4.3, Fig. 7), or the same surface.
// Needs `frame`, `surface_image`, `guide_image`, `hit_image` from the includer.
#ifndef PAIR_GLSL
#define PAIR_GLSL
#include "camera.glsl"
#include "guide.glsl"
#include "hit.glsl"
#include "surface.glsl"

struct Pixel {
    ivec3 texel;
    vec3 position;      // render space
    vec3 v;             // towards its eye, unit length
    float distance;     // along the view's axis, metres
    uint instance;
    Surface surface;
};

// Same surface for the purpose of reuse: cosine between normals, distance from the plane relative to the view's.
const float LEAST_COSINE = 0.9;
const float PLANE_TOLERANCE = 0.01;

Guide load_guide(ivec3 texel) { return unpack_guide(texelFetch(guide_image, texel, 0)); }

Pixel load_pixel(ivec3 texel) {
    Guide g = load_guide(texel);
    Pixel p;
    p.texel = texel;
    p.position = render_position(texel.z, vec2(texel.xy) + 0.5, g.depth);
    p.v = normalize(eye_position(texel.z) - p.position);
    p.distance = view_distance(texel.z, g.depth);
    p.instance = g.instance;
    p.surface = unpack_surface(texelFetch(surface_image, texel, 0));
    return p;
}

// Where the other eye sees, in the plane of p, what p reflects from `hit_distance` away. The virtual image stands that
// far behind p on p's own view ray (not mirrored about the normal: a rough lobe's sampled direction would leave the
// pixel); its line to the other eye meets the plane. Pixels; false: behind that eye or the plane.
bool image_in(Pixel p, uint eye, float hit_distance, out vec2 pixel) {
    vec3 to_eye = eye_position(eye) - p.position;
    float height = dot(to_eye, p.surface.normal);
    float along = hit_distance * dot(p.v, p.surface.normal);
    if (height <= 0.0 || height + along <= 0.0) return false;
    // From the eye's side, so that an image at infinity loses no digits.
    vec3 at = eye_position(eye) - (to_eye + p.v * hit_distance) * (height / (height + along));
    vec4 clip = frame.eyes[eye].clip_from_render * vec4(at, 1.0);
    pixel = screen_from_clip(clip).xy;
    return clip.w > 0.0 && all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, vec2(frame.size)));
}

// Half the lobe's width as the disparity of what it reflects, pixels.
float lobe_pixels(Pixel p, float hit_distance) {
    float alpha = p.surface.roughness * p.surface.roughness;
    float spread = alpha * hit_distance / max(hit_distance + p.distance, 1e-6);
    return spread / pixel_size(uint(p.texel.z));
}

// Whether q, a pixel's guide at `position`, is the same surface for the purpose of reuse.
bool same_surface(Pixel p, Guide q, vec3 position) {
    return q.instance == p.instance && (q.roughness < frame.delta_roughness) == is_mirror(p.surface) &&
           dot(unpack_direction(q.normal), p.surface.normal) >= LEAST_COSINE &&
           abs(dot(position - p.position, p.surface.face_normal)) <= PLANE_TOLERANCE * p.distance;
}

// How far away an instance reflects about a pixel: that pixel's own hit, or a known neighbour's; −1: nobody knows.
float reflected_distance(ivec3 texel, uint instance) {
    const ivec2 NEAR[9] = ivec2[9](ivec2(0, 0), ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1), ivec2(2, 0),
                                   ivec2(-2, 0), ivec2(0, 2), ivec2(0, -2));
    for (int i = 0; i < 9; ++i) {
        ivec3 tap = texel + ivec3(NEAR[i], 0);
        if (any(lessThan(tap.xy, ivec2(0))) || any(greaterThanEqual(tap.xy, ivec2(frame.size)))) continue;
        if (load_guide(tap).instance != instance) continue;
        uvec4 word = texelFetch(hit_image, tap, 0);
        if (hit_status(word) == SKY) return frame.ray_length;
        if (hit_status(word) == HIT) return unpack_hit(word).distance;
    }
    return -1.0;
}

// One candidate: the place in the other eye's image, its surface, its own hit and the way back must all agree.
bool pair_at(Pixel p, float hit_distance, float tolerance, out ivec3 pair) {
    uint other = 1u - uint(p.texel.z);
    vec2 pixel;
    pair = ivec3(0);
    if (!image_in(p, other, hit_distance, pixel)) return false;
    pair = ivec3(ivec2(pixel), other);
    Guide g = load_guide(pair);
    vec3 position = render_position(other, vec2(pair.xy) + 0.5, g.depth);
    if (g.instance == 0u || !same_surface(p, g, position)) return false;
    Pixel q = p;
    q.texel = pair;
    q.position = position;
    q.v = normalize(eye_position(other) - position);
    q.surface.normal = unpack_direction(g.normal);
    // What the other pixel itself reflects decides the way back; an unknown one has only our distance.
    uvec4 word = texelFetch(hit_image, pair, 0);
    float back_distance = hit_distance;
    if (hit_status(word) == HIT) back_distance = unpack_hit(word).distance;
    if (hit_status(word) == SKY) back_distance = frame.ray_length;
    vec2 back;
    if (!image_in(q, uint(p.texel.z), back_distance, back)) return false;
    return distance(back, vec2(p.texel.xy) + 0.5) <= tolerance;
}

// The virtual image's pair, else the surface's own where the lobe is wide enough to cover the difference.
bool find_pair(Pixel p, out ivec3 pair) {
    float d = reflected_distance(p.texel, p.instance);
    uint other = 1u - uint(p.texel.z);
    vec2 surface_pixel;
    bool surface_seen = image_in(p, other, 0.0, surface_pixel);
    // Where this eye knows no distance, the other one may, about the same place of the surface.
    if (d < 0.0 && surface_seen) d = reflected_distance(ivec3(ivec2(surface_pixel), other), p.instance);
    // Half a pixel of rounding each way comes on top of the lobe's footprint.
    if (d >= 0.0 && pair_at(p, d, max(1.0, lobe_pixels(p, d)) + 0.5, pair)) return true;
    pair = ivec3(0);
    if (is_mirror(p.surface) || !surface_seen || d < 0.0) return false;
    vec2 image_pixel;
    float lobe = lobe_pixels(p, d);
    if (!image_in(p, other, d, image_pixel) || distance(surface_pixel, image_pixel) > lobe) return false;
    return pair_at(p, 0.0, max(1.0, lobe) + 0.5, pair);
}

#endif
