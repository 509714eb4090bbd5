// What the passes of ambient occlusion store for a pixel (seed 001: Wu, adaptive stereo ambient occlusion, its §§ 3 and 4):
// the visibility of its surroundings (1: open) with the weight of that value and the pixel's depth; and the pixel of the other
// eye that shows the same place.
#ifndef AO_GLSL
#define AO_GLSL

// A texel of the map of pairs. x: raw depth; y: the other eye's pixel (x | y << 14) and the two flags below.
const uint PAIRED = 1u << 28;
// The pixel takes its raw visibility from its pair, which is estimated for both.
const uint COPIES = 1u << 29;

ivec3 pair_of(uvec2 word, int eye) { return ivec3(word.y & 0x3fffu, word.y >> 14 & 0x3fffu, 1 - eye); }

// Visibility and the weight behind it, each in [0, 1], 16 bits each; raw depth.
uvec2 pack_visibility(float visibility, float weight, float depth) {
    return uvec2(packUnorm2x16(vec2(visibility, weight)), floatBitsToUint(depth));
}

// x: visibility, y: weight.
vec2 unpack_visibility(uint word) { return unpackUnorm2x16(word); }

// Whether the difference between the eyes is visible (seed 001, equation 2). Equal values never differ, not even in black,
// where the quotient of the equation would be 0/0.
bool differs_visibly(float own, float other, float threshold) {
    float difference = abs(own - other);
    return difference > 0.0 && difference >= threshold * own;
}

#endif
