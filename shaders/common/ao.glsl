// What the passes of ambient occlusion keep of a pixel: how visible the surroundings are from it (1: open), with how much
// that is worth and the pixel's depth; and which pixel of the other eye shows the same place (seed 001: Wu, adaptive
// stereo ambient occlusion, its §§ 3 and 4).
#ifndef AO_GLSL
#define AO_GLSL

// A pixel of a map of pairs: x: raw depth; y: the other eye's pixel (x | y << 14) and what is true of it.
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

// The difference between the eyes is seen (seed 001, equation 2). Equal values are equal, however dark: the quotient of the
// equation would be 0/0 in black.
bool differs_visibly(float own, float other, float threshold) {
    float difference = abs(own - other);
    return difference > 0.0 && difference >= threshold * own;
}

#endif
