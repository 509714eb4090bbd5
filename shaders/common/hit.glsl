// How a ray ended, in four words: where (unorm 2×16, 0.03 px); its direction; length | status | eye | confidence; density.
#ifndef HIT_GLSL
#define HIT_GLSL
#include "math.glsl"

// No ray. With confidence above 0, the direction is known to be black, because the triangle itself blocks it.
const uint NOTHING = 0u;
const uint HIT = 1u;
// The ray reached infinity inside a view, and went behind nothing on its way.
const uint SKY = 2u;
// The ray left the view, went behind something, met a back face or ran out of steps. The fallback stands in for it.
const uint UNKNOWN = 3u;
// The ray hit the scene's geometry where no eye sees it. The hit's radiance lies in an image of its own, at the ray's pixel.
// The status has only two bits, so this one is stored as UNKNOWN with confidence above 0, which UNKNOWN itself never has.
const uint SHADED = 4u;

struct Hit {
    uint status;
    vec2 uv;            // place of the hit in that eye's image
    uint eye;           // the eye in whose image the hit lies
    vec3 direction;     // of the ray, render space
    float distance;     // along it, metres
    float pdf;          // of the direction, over solid angle; 1 for mirrors
    float confidence;   // 0–1
};

// The length keeps 12 bits of its mantissa (0.02 %), which matches the 1/32 px of the hit's place.
uvec4 pack_hit(Hit h) {
    uint flags = min(h.status, UNKNOWN) | h.eye << 2 | uint(clamp(h.confidence, 0.0, 1.0) * 255.0 + 0.5) << 3;
    return uvec4(packUnorm2x16(h.uv), pack_direction(h.direction), (floatBitsToUint(h.distance) & ~0x7ffu) | flags,
                 floatBitsToUint(h.pdf));
}

Hit unpack_hit(uvec4 w) {
    Hit h;
    h.status = w.z & 3u;
    h.uv = unpackUnorm2x16(w.x);
    h.eye = w.z >> 2 & 1u;
    h.direction = unpack_direction(w.y);
    h.distance = uintBitsToFloat(w.z & ~0x7ffu);
    h.pdf = uintBitsToFloat(w.w);
    h.confidence = float(w.z >> 3 & 0xffu) * (1.0 / 255.0);
    if (h.status == UNKNOWN && h.confidence > 0.0) h.status = SHADED;
    return h;
}

bool contributes(uvec4 w) { return (w.z & 0x7fbu) != 0u; }

#endif
