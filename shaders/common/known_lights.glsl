// What is known of a pixel's first 64 lights without tracing a ray. Each light has one bit that says that all of it arrives
// (xy), and one that says that it is hidden (zw). With neither bit set the pixel lies in the light's penumbra or sees it
// through glass, the light shines from behind the surface, or no ray has asked for it.
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
