// All that the resolve must know of a neighbour before it uses the neighbour's hit. It lies in one texel, so that one fetch
// does instead of three.
#ifndef GUIDE_GLSL
#define GUIDE_GLSL

struct Guide {
    uint normal;      // packed direction
    float depth;      // raw
    uint instance;    // id + 1; 0: the pixel traces no ray
    float roughness;
};

uvec4 pack_guide(Guide g) {
    return uvec4(g.normal, floatBitsToUint(g.depth), g.instance, floatBitsToUint(g.roughness));
}

Guide unpack_guide(uvec4 w) { return Guide(w.x, uintBitsToFloat(w.y), w.z, uintBitsToFloat(w.w)); }

#endif
