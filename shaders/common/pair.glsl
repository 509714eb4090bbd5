// A pixel with its surface, which pixels show the same surface, and where the other eye sees what a pixel reflects (paper
// §4.3, Fig. 7).
// Needs `frame`, `surface_image` and `guide_image` from the includer.
#ifndef PAIR_GLSL
#define PAIR_GLSL
#include "camera.glsl"
#include "guide.glsl"
#include "surface.glsl"

struct Pixel {
    ivec3 texel;
    vec3 position;      // render space
    vec3 v;             // towards its eye, unit length
    float distance;     // along the view's axis, metres
    uint instance;
    Surface surface;
};

// When two pixels show the same surface for the purpose of reuse: the least cosine between their normals, and the largest
// distance from the plane relative to the distance along the view's axis.
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

// The pixel in which `eye` sees what p reflects from `hit_distance` away. The virtual image stands that far behind p, on p's
// own view ray. (The sampled direction is not mirrored about the normal: in a rough lobe it would lead away from the pixel.)
// The line from the virtual image to the eye meets p's plane in the pixel. False: that is behind the eye or the plane, or
// outside the view.
bool image_in(Pixel p, uint eye, float hit_distance, out vec2 pixel) {
    vec3 to_eye = eye_position(eye) - p.position;
    float height = dot(to_eye, p.surface.normal);
    float along = hit_distance * dot(p.v, p.surface.normal);
    if (height <= 0.0 || height + along <= 0.0) return false;
    // The line is followed from the eye, so that a virtual image at infinity loses no precision.
    vec3 at = eye_position(eye) - (to_eye + p.v * hit_distance) * (height / (height + along));
    vec4 clip = frame.eyes[eye].clip_from_render * vec4(at, 1.0);
    pixel = screen_from_clip(clip).xy;
    return clip.w > 0.0 && all(greaterThanEqual(pixel, vec2(0.0))) && all(lessThan(pixel, vec2(frame.size)));
}

// Half the lobe's width, in pixels: how far the lobe spreads the reflection on the screen.
float lobe_pixels(Pixel p, float hit_distance) {
    float alpha = p.surface.roughness * p.surface.roughness;
    float spread = alpha * hit_distance / max(hit_distance + p.distance, 1e-6);
    return spread / pixel_size(uint(p.texel.z));
}

// Whether a pixel with guide q, whose surface is at `position`, shows p's surface for the purpose of reuse.
bool same_surface(Pixel p, Guide q, vec3 position) {
    return q.instance == p.instance && (q.roughness < frame.delta_roughness) == is_mirror(p.surface) &&
           dot(unpack_direction(q.normal), p.surface.normal) >= LEAST_COSINE &&
           abs(dot(position - p.position, p.surface.face_normal)) <= PLANE_TOLERANCE * p.distance;
}

#endif
