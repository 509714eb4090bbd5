// From pixels to render space and back. Needs `frame` (FrameUniform) from the includer.
#ifndef CAMERA_GLSL
#define CAMERA_GLSL

// Direction through a point of the image (pixels), scaled so that z = −1 in the eye's view space.
vec3 view_ray(uint eye, vec2 pixel) {
    vec4 t = frame.eyes[eye].tangents;
    vec2 uv = pixel / vec2(frame.size);
    return vec3(mix(t.x, t.y, uv.x), mix(t.w, t.z, uv.y), -1.0);
}

// Unit length, render space.
vec3 pixel_direction(uint eye, vec2 pixel) {
    return normalize(mat3(frame.eyes[eye].render_from_view) * view_ray(eye, pixel));
}

// Distance along −Z of a raw depth.
float view_distance(uint eye, float depth) { return frame.eyes[eye].position_near.w / depth; }

vec3 render_position(uint eye, vec2 pixel, float depth) {
    vec3 view = view_ray(eye, pixel) * view_distance(eye, depth);
    return (frame.eyes[eye].render_from_view * vec4(view, 1.0)).xyz;
}

vec3 eye_position(uint eye) { return frame.eyes[eye].position_near.xyz; }

// Width of a pixel at distance 1.
float pixel_size(uint eye) {
    vec4 t = frame.eyes[eye].tangents;
    return max((t.y - t.x) / float(frame.size.x), (t.w - t.z) / float(frame.size.y));
}

// Where a reflection ray starts: off the plane by what half a pixel of it can rise above its centre's depth.
vec3 ray_origin(uint eye, vec3 position, vec3 face_normal, float depth) {
    float distance = view_distance(eye, depth);
    vec3 n = mat3(frame.eyes[eye].view_from_render) * face_normal;
    float rise = pixel_size(eye) * (0.5 * (abs(n.x) + abs(n.y)) + 0.05);
    return position + face_normal * (distance * rise);
}

// Pixels (x, y) and raw depth of a clip-space point.
vec3 screen_from_clip(vec4 clip) {
    vec3 ndc = clip.xyz / clip.w;
    return vec3((vec2(ndc.x, -ndc.y) * 0.5 + 0.5) * vec2(frame.size), ndc.z);
}

#endif
