// The density with which a pixel's own ray is sampled in a direction (Tokuyoshi & Eto 2023), for many directions of one lobe.
// The lobe's constants are computed once, and vectors need no unit length where their length cancels.
// Needs brdf.glsl. Mirrors have no density.
#ifndef LOBE_GLSL
#define LOBE_GLSL

struct Lobe {
    vec3 n;
    vec3 v;
    float a2;       // α²
    float scale;    // density divided by the distribution of normals
};

Lobe make_lobe(vec3 n, vec3 v, float roughness) {
    float alpha = roughness * roughness, a2 = alpha * alpha;
    float z = max(dot(n, v), 1e-4);
    float xy2 = max(1.0 - z * z, 0.0);
    float s2 = square(1.0 + sqrt(xy2));
    float k = (1.0 - a2) * s2 / (s2 + a2 * z * z);
    return Lobe(n, v, a2, 0.5 / (k * z + sqrt(a2 * xy2 + z * z)));
}

// The distribution of normals D at the half vector of v and l. `half_vector` receives v + l, not normalised.
float lobe_distribution(Lobe b, vec3 l, out vec3 half_vector) {
    half_vector = b.v + l;
    float hh = dot(half_vector, half_vector), nh = dot(b.n, half_vector);
    vec3 c = cross(b.n, half_vector);
    float d = nh * nh * b.a2 + dot(c, c);
    return b.a2 * hh * hh / max(PI * d * d, 1e-30);
}

float lobe_density(Lobe b, vec3 l) {
    vec3 h;
    return lobe_distribution(b, l, h) * b.scale;
}

#endif
