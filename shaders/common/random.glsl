// Samples as a function of (seed, frame, pixel, sample, stream): Owen-scrambled Sobol points, so that the samples
// of a pixel are stratified among themselves and independent between pixels, eyes and seeds.
// Source: Burley, "Practical Hash-based Owen Scrambling", JCGT 9(4), 2020 (the permutation's constants are his).
#ifndef RANDOM_GLSL
#define RANDOM_GLSL

uint mix_bits(uint x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    x ^= x >> 16;
    return x;
}

uint combine(uint seed, uint x) { return mix_bits(seed * 0x9e3779b9u + x + 0x85ebca6bu); }

// An Owen scramble of bit-reversed x: each bit is flipped by a hash of the bits below it.
uint laine_karras(uint x, uint seed) {
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

uint owen(uint x, uint seed) { return bitfieldReverse(laine_karras(bitfieldReverse(x), seed)); }

// The second Sobol dimension; the first is the bit reversal of the index.
uint sobol_second(uint index) {
    uint v = 1u << 31, result = 0u;
    for (; index != 0u; index >>= 1, v ^= v >> 1) {
        if ((index & 1u) != 0u) result ^= v;
    }
    return result;
}

// 24 bits: the largest value is below 1.
float unit_float(uint x) { return float(x >> 8) * (1.0 / 16777216.0); }

// Sample `index` of the pixel's sequence; `token` is the eye's stream.
vec2 sample_2d(uint seed, uint token, uvec2 pixel, uint index) {
    uint h = combine(combine(combine(combine(0u, seed), token), pixel.x), pixel.y);
    uint shuffled = owen(index, h);
    uint x = owen(bitfieldReverse(shuffled), combine(h, 1u));
    uint y = owen(sobol_second(shuffled), combine(h, 2u));
    return vec2(unit_float(x), unit_float(y));
}

// Purposes of a ray's single random numbers (draw_1d, lattice_1d) and pairs of them (draw_2d).
const uint DRAW_FADE = 3u;
const uint DRAW_ASK = 4u;
const uint DRAW_RIM = 5u;
const uint DRAW_GATHER = 6u;
const uint DRAW_EMITTER = 7u;
const uint DRAW_EMITTER_POINT = 8u;
// The pair that chooses a point of light i has the purpose DRAW_LIGHT + i.
const uint DRAW_LIGHT = 16u;

// Identifies the random numbers of one sample of one pixel.
struct Draws {
    uint seed;
    uint token;
    uvec2 pixel;
    uint index;
};

// Two numbers for one purpose, stratified over the samples of the pixel.
vec2 draw_2d(Draws d, uint purpose) { return sample_2d(combine(d.seed, purpose), d.token, d.pixel, d.index); }

// A number in [0, 1) for one purpose of a pixel's sample, independent of the numbers that choose its direction.
float draw_1d(uint seed, uint token, uvec2 pixel, uint index, uint purpose) {
    uint h = combine(combine(combine(combine(0u, seed), token), pixel.x), pixel.y);
    return unit_float(combine(combine(h, purpose), index));
}

// As draw_1d, but evenly distributed over neighbouring pixels: a rank-1 lattice (Roberts 2018) with one random offset for each
// sample. In every small neighbourhood, a share s of the numbers lies below s.
float lattice_1d(uint seed, uint token, uvec2 pixel, uint index, uint purpose) {
    float offset = unit_float(combine(combine(combine(combine(0u, seed), token), purpose), index));
    return fract(fract(float(pixel.x) * 0.7548776662) + fract(float(pixel.y) * 0.5698402910) + offset);
}

#endif
