// What is known of a pixel's first 64 lights without a ray: a bit each that the light arrives whole (xy), and that it is
// hidden (zw). Neither: it lies in a penumbra or behind glass, shines from behind, or was not asked.
#ifndef KNOWN_LIGHTS_GLSL
#define KNOWN_LIGHTS_GLSL

const uint MOST_KNOWN = 64u;

bool is_known(uvec4 known, uint i, out vec3 share) {
    share = vec3(0.0);
    if (i >= MOST_KNOWN) return false;
    uint word = i >> 5, bit = 1u << (i & 31u);
    if ((known[word] & bit) != 0u) {
        share = vec3(1.0);
        return true;
    }
    return (known[word + 2u] & bit) != 0u;
}

void learn(inout uvec4 known, uint i, vec3 share) {
    if (i >= MOST_KNOWN) return;
    uint word = i >> 5, bit = 1u << (i & 31u);
    if (all(equal(share, vec3(1.0)))) known[word] |= bit;
    if (all(equal(share, vec3(0.0)))) known[word + 2u] |= bit;
}

#endif
