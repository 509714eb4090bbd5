// From pixels to render space and back. Needs `frame` (FrameUniform) from the includer.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

// The ray through a point of the image (in pixels), scaled so that it advances by 1 along the view's axis.
vec3 scaled_ray(uint eye, vec2 pixel) {
    return frame.eyes[eye].ray_first.xyz + pixel.x * frame.eyes[eye].ray_across.xyz + pixel.y * frame.eyes[eye].ray_down.xyz;
}

// Unit length, render space.
vec3 pixel_direction(uint eye, vec2 pixel) { return normalize(scaled_ray(eye, pixel)); }

// The distance along the view's axis, in metres, that belongs to a raw depth.
float view_distance(uint eye, float depth) { return frame.eyes[eye].position_near.w / depth; }

vec3 render_position(uint eye, vec2 pixel, float depth) {
    return frame.eyes[eye].position_near.xyz + scaled_ray(eye, pixel) * view_distance(eye, depth);
}

// An eye's constants, for loops over many pixels: a software device loads them lane by lane, so they are loaded once.
struct EyeRays {
    vec3 origin;
    vec3 first;
    vec3 across;
    vec3 down;
    float near;
};

EyeRays eye_rays(uint eye) {
    return EyeRays(frame.eyes[eye].position_near.xyz, frame.eyes[eye].ray_first.xyz, frame.eyes[eye].ray_across.xyz,
                   frame.eyes[eye].ray_down.xyz, frame.eyes[eye].position_near.w);
}

vec3 position_along(EyeRays e, vec2 pixel, float depth) {
    return e.origin + (e.first + pixel.x * e.across + pixel.y * e.down) * (e.near / depth);
}

vec3 eye_position(uint eye) { return frame.eyes[eye].position_near.xyz; }

// Width of a pixel at distance 1.
float pixel_size(uint eye) {
    return max(length(frame.eyes[eye].ray_across.xyz), length(frame.eyes[eye].ray_down.xyz));
}

// Where a reflection ray starts: lifted off the surface by as much as the surface's plane can rise, within half a pixel, above
// the depth at the pixel's centre.
vec3 ray_origin(uint eye, vec3 position, vec3 face_normal, float depth) {
    float distance = view_distance(eye, depth);
    vec3 n = mat3(frame.eyes[eye].view_from_render) * face_normal;
    float rise = pixel_size(eye) * (0.5 * (abs(n.x) + abs(n.y)) + 0.05);
    return position + face_normal * (distance * rise);
}

// Whether a pixel is shown, which those of the guard band are not.
bool is_shown(ivec2 pixel) {
    return all(greaterThanEqual(pixel, ivec2(frame.guard))) &&
           all(lessThan(pixel, ivec2(frame.size) - ivec2(frame.guard)));
}

// Pixels (x, y) and raw depth of a clip-space point.
vec3 screen_from_clip(vec4 clip) {
    vec3 ndc = clip.xyz / clip.w;
    return vec3((vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(frame.size), ndc.z);
}

#endif
