// GGX reflection: distribution, visibility, Fresnel, and the sampling of visible normals within the bounded cap.
// Sources: Walter et al. 2007; Heitz 2014 (height-correlated Smith); Dupuy & Benyoub 2023 (spherical caps);
// Tokuyoshi & Eto 2023 (the cap's bound).
#ifndef BRDF_GLSL
#define BRDF_GLSL
#include "math.glsl"

// D = α²/(π((n·h)²α² + |n×h|²)²): the cross product keeps the small sine that 1 − (n·h)² would lose.
float ggx_distribution(vec3 n, vec3 h, float alpha) {
    float a2 = alpha * alpha;
    vec3 c = cross(n, h);
    float d = square(dot(n, h)) * a2 + dot(c, c);
    return a2 / (PI * d * d);
}

// G₂/(4 (n·v)(n·l)).
float smith_visibility(float nv, float nl, float alpha) {
    float a2 = alpha * alpha;
    float v = nl * sqrt(nv * nv * (1.0 - a2) + a2);
    float l = nv * sqrt(nl * nl * (1.0 - a2) + a2);
    return 0.5 / max(v + l, 1e-12);
}

vec3 schlick(vec3 f0, float vh) {
    float m = clamp(1.0 - vh, 0.0, 1.0);
    float m2 = m * m;
    return f0 + (1.0 - f0) * (m2 * m2 * m);
}

// f·cos θ_l with Fresnel; zero below the horizon.
vec3 ggx_times_cosine(vec3 n, vec3 v, vec3 l, float alpha, vec3 f0) {
    float nv = dot(n, v), nl = dot(n, l);
    if (nl <= 0.0 || nv <= 0.0) return vec3(0.0);
    vec3 h = normalize_or(v + l, n);
    return ggx_distribution(n, h, alpha) * smith_visibility(nv, nl, alpha) * nl * schlick(f0, dot(v, h));
}

float cap_bound(vec3 i, float alpha) {
    float s = 1.0 + length(i.xy);
    float a2 = alpha * alpha, s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * i.z * i.z);
}

// A reflected direction; i and the result in the surface's basis (z = normal), i.z > 0.
vec3 sample_reflection(vec3 i, float alpha, vec2 u) {
    vec3 i_std = normalize(vec3(i.xy * alpha, i.z));
    float b = cap_bound(i, alpha) * i_std.z;
    float phi = 2.0 * PI * u.x;
    float z = fma(1.0 - u.y, 1.0 + b, -b);
    float r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    vec3 m_std = i_std + vec3(r * cos(phi), r * sin(phi), z);
    vec3 m = normalize_or(vec3(m_std.xy * alpha, m_std.z), vec3(0.0, 0.0, 1.0));
    return 2.0 * dot(i, m) * m - i;
}

// Its density over solid angle: D/(2(k·i_z + t)).
float reflection_pdf(vec3 i, vec3 o, float alpha) {
    vec3 m = normalize_or(i + o, vec3(0.0, 0.0, 1.0));
    float d = ggx_distribution(vec3(0.0, 0.0, 1.0), m, alpha);
    float t = length(vec3(alpha * i.xy, i.z));
    return d / max(2.0 * (cap_bound(i, alpha) * i.z + t), 1e-12);
}

#endif
