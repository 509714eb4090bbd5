// Constants, octahedral directions, bases.
#ifndef MATH_GLSL
#define MATH_GLSL

const float PI = 3.14159265358979;
const float FLT_MAX = 3.402823466e38;

float luminance(vec3 c) { return dot(c, vec3(0.2126, 0.7152, 0.0722)); }

float square(float x) { return x * x; }

// Octahedral encoding of a unit vector (Meyer et al. 2010); each coordinate lies in [−1, 1].
vec2 octahedral(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    vec2 folded = (1.0 - abs(p.yx)) * vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z >= 0.0 ? p : folded;
}

vec3 from_octahedral(vec2 p) {
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float t = max(-n.z, 0.0);
    n.x += n.x >= 0.0 ? -t : t;
    n.y += n.y >= 0.0 ? -t : t;
    return normalize(n);
}

uint pack_direction(vec3 n) { return packSnorm2x16(octahedral(n)); }
vec3 unpack_direction(uint word) { return from_octahedral(unpackSnorm2x16(word)); }

// Columns: two tangents and the normal itself (Duff et al. 2017).
mat3 basis(vec3 n) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

// The first vector, normalised; the second one when the first is too short or too long to normalise.
vec3 normalize_or(vec3 v, vec3 otherwise) {
    float l = dot(v, v);
    return l > 1e-30 && l < 1e30 ? v * inversesqrt(l) : otherwise;
}

#endif
