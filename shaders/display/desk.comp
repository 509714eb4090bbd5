#version 460
// In: a stereo picture and the reference that may be shown beside it (two layers each), and the text over them (two layers,
// premultiplied alpha). Out: the window's picture in display values, in one of the modes that give each eye its own picture.
// Red-cyan: E. Dubois, "Conversion of a stereo pair to anaglyph with the least-squares projection method", 2009.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform sampler2DArray still;
layout(set = 0, binding = 1) uniform sampler2DArray reference;
layout(set = 0, binding = 2) uniform sampler2DArray words;
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D window;

// 0 side by side, 1 side by side at half width, 2 side by side for crossed eyes, 3 red-cyan, 4 left eye, 5 right eye
layout(constant_id = 0) const int MODE = 0;
// 0 no picture, 1 a picture for each eye, 2 for both eyes the reference beside the mirrored picture
layout(constant_id = 1) const int KIND = 0;
// 0 pixel for pixel, 1 enlarged, 2 reduced
layout(constant_id = 2) const int SAMPLING = 0;
// 1: texels are display values, 0: the format decodes them
layout(constant_id = 3) const int IS_ENCODED = 0;

layout(push_constant) uniform Desk {
    // x, y, width, height within an eye's view, pixels
    ivec4 picture;
    // x, y, width, height within the window, pixels; width 0: none
    ivec4 patch_rect;
    ivec2 window_size;
    // with KIND 2: the eye whose pictures are shown
    int eye;
    // the eyes' pictures are moved apart by this many pixels
    int apart;
    // background, linear
    float ground;
    // brightness of the patch, display value
    float patch_value;
} desk;

float decode(float v) { return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4); }
float encode(float v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055; }
vec3 decode(vec3 v) { return vec3(decode(v.r), decode(v.g), decode(v.b)); }
vec3 encode(vec3 v) { return vec3(encode(v.r), encode(v.g), encode(v.b)); }

vec3 texel(sampler2DArray image, ivec2 at, int layer) {
    vec3 value = texelFetch(image, ivec3(at, layer), 0).rgb;
    return IS_ENCODED == 1 ? decode(value) : value;
}

// Mean over the footprint of a pixel when shrunk, bilinear when enlarged, exact at equal size.
vec3 sampled(sampler2DArray image, int layer, ivec2 pixel, vec2 size) {
    if (SAMPLING == 0) {
        return texel(image, pixel, layer);
    }
    ivec2 texels = textureSize(image, 0).xy;
    vec2 at = vec2(pixel);
    vec2 scale = vec2(texels) / size;
    if (SAMPLING == 1) {
        vec2 p = (at + 0.5) * scale - 0.5;
        ivec2 low = ivec2(floor(p));
        vec2 f = p - vec2(low);
        ivec2 a = clamp(low, ivec2(0), texels - 1);
        ivec2 b = clamp(low + 1, ivec2(0), texels - 1);
        vec3 upper = mix(texel(image, a, layer), texel(image, ivec2(b.x, a.y), layer), f.x);
        vec3 lower = mix(texel(image, ivec2(a.x, b.y), layer), texel(image, b, layer), f.x);
        return mix(upper, lower, f.y);
    }
    vec2 from = at * scale;
    vec2 to = from + scale;
    ivec2 first = ivec2(floor(from + 1e-3));
    ivec2 last = min(ivec2(ceil(to - 1e-3)), min(texels, first + 16));
    vec3 sum = vec3(0.0);
    float weight = 0.0;
    for (int y = first.y; y < last.y; y++) {
        for (int x = first.x; x < last.x; x++) {
            vec2 inside = min(to, vec2(x + 1, y + 1)) - max(from, vec2(x, y));
            float w = max(inside.x, 0.0) * max(inside.y, 0.0);
            sum += w * texel(image, ivec2(x, y), layer);
            weight += w;
        }
    }
    return sum / max(weight, 1e-6);
}

vec3 seen(int eye, ivec2 at) {
    vec3 value = vec3(desk.ground);
    ivec2 q = at - desk.picture.xy;
    if (KIND == 1) {
        q.x -= (eye == 0 ? -1 : 1) * desk.apart / 2;
    }
    if (KIND != 0 && all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, desk.picture.zw))) {
        if (KIND == 1) {
            value = sampled(still, eye, q, vec2(desk.picture.zw));
        } else {
            int half_width = desk.picture.z / 2;
            vec2 size = vec2(half_width, desk.picture.w);
            if (q.x < half_width) {
                value = sampled(reference, desk.eye, q, size);
            } else {
                value = sampled(still, desk.eye, ivec2(2 * half_width - 1 - q.x, q.y), size);
            }
        }
    }
    vec4 word = texelFetch(words, ivec3(at, eye), 0);
    return word.rgb + (1.0 - word.a) * value;
}

void main() {
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(at, desk.window_size))) {
        return;
    }
    vec3 value = vec3(desk.ground);
    int half_width = desk.window_size.x / 2;
    bool is_right = at.x >= half_width;
    ivec2 inside = ivec2(is_right ? at.x - half_width : at.x, at.y);
    if (MODE == 0 || MODE == 2) {
        if (inside.x < half_width) {
            value = seen(is_right != (MODE == 2) ? 1 : 0, inside);
        }
    } else if (MODE == 1) {
        if (inside.x < half_width) {
            ivec2 p = ivec2(2 * inside.x, inside.y);
            int eye = is_right ? 1 : 0;
            value = 0.5 * (seen(eye, p) + seen(eye, p + ivec2(1, 0)));
        }
    } else if (MODE == 3) {
        const mat3 LEFT = mat3(0.4561, -0.0400822, -0.0152161, 0.500484, -0.0378246, -0.0205971, 0.176381, -0.0157589,
                               -0.00546856);
        const mat3 RIGHT = mat3(-0.0434706, 0.378476, -0.0721527, -0.0879388, 0.73364, -0.112961, -0.00155529,
                                -0.0184503, 1.2264);
        value = clamp(LEFT * seen(0, at) + RIGHT * seen(1, at), 0.0, 1.0);
    } else {
        value = seen(MODE - 4, at);
    }
    vec3 shown = encode(value);
    ivec2 p = at - desk.patch_rect.xy;
    if (all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, desk.patch_rect.zw))) {
        shown = vec3(desk.patch_value);
    }
    imageStore(window, at, vec4(shown, 1.0));
}
