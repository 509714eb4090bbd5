// The reflection ray of a surface, for the screen-space methods and for the reference. Needs `frame`.
#ifndef REFLECT_GLSL
#define REFLECT_GLSL
#include "brdf.glsl"
#include "surface.glsl"

struct ReflectionRay {
    vec3 direction;
    float pdf;       // over solid angle; 1 for a mirror, whose weight is Fresnel alone
    bool above;      // above the shading normal's horizon; otherwise the sample counts as zero
    bool open;       // above the triangle's horizon too; otherwise the triangle itself blocks it, and it is black
};

bool is_mirror(Surface s) { return s.roughness < frame.delta_roughness; }

ReflectionRay reflection_ray(Surface s, vec3 v, vec2 u) {
    ReflectionRay ray;
    if (is_mirror(s)) {
        ray.direction = reflect(-v, s.normal);
        ray.pdf = 1.0;
    } else {
        float alpha = square(s.roughness);
        mat3 local = basis(s.normal);
        vec3 i = v * local;
        vec3 o = sample_reflection(i, alpha, u);
        ray.direction = normalize(local * o);
        ray.pdf = reflection_pdf(i, o, alpha);
    }
    ray.above = dot(ray.direction, s.normal) > 0.0;
    ray.open = ray.above && dot(ray.direction, s.face_normal) > 0.0;
    return ray;
}

// f·cos/pdf of a direction, with Fresnel.
vec3 reflection_weight(Surface s, vec3 v, vec3 l, float pdf) {
    if (is_mirror(s)) return schlick(s.f0, dot(s.normal, v));
    return ggx_times_cosine(s.normal, v, l, square(s.roughness), s.f0) / pdf;
}

#endif
