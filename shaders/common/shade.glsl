// Light that leaves a surface towards v without its traced reflection: emission, punctual lights (no shadows,
// paper §5), diffuse environment, and the specular environment only where no ray is traced.
// One function for the `lighting` pass and for the reference's hits. Needs `lights` (LightData[]), `brdf_table`
// (sampler2D: F0·A + B) and what environment.glsl needs.
#ifndef SHADE_GLSL
#define SHADE_GLSL
#include "brdf.glsl"
#include "environment.glsl"
#include "surface.glsl"

// Punctual lights have no size; a mirror would show none of it. Their highlights are as wide as at this roughness.
const float PUNCTUAL_ROUGHNESS = 0.1;
// Beyond what any target holds, and finite after the lobe (at most 1/(4π α²) of it) and a sum over lights.
const float MOST_IRRADIANCE = 1e30;

// Directional albedo of the specular lobe, F0·A + B, integrated from the BRDF above.
vec3 specular_albedo(vec3 f0, float nv, float roughness) {
    vec2 size = vec2(textureSize(brdf_table, 0));
    vec2 uv = (vec2(clamp(nv, 0.0, 1.0), clamp(roughness, 0.0, 1.0)) * (size - 1.0) + 0.5) / size;
    vec2 ab = textureLod(brdf_table, uv, 0.0).xy;
    return f0 * ab.x + ab.y;
}

// Irradiance on a surface facing the light, and the direction towards it.
vec3 incident(LightData light, vec3 position, out vec3 l) {
    if (light.kind == 0u) {
        l = -light.direction;
        return min(light.color, vec3(MOST_IRRADIANCE));
    }
    vec3 to_light = light.position - position;
    float d2 = max(dot(to_light, to_light), 1e-8);
    l = to_light * inversesqrt(d2);
    // KHR_lights_punctual's window.
    float q = d2 / square(light.range);
    float window = clamp(1.0 - q * q, 0.0, 1.0);
    float cone = 1.0;
    if (light.kind == 2u) {
        float c = dot(light.direction, -l);
        cone = square(clamp((c - light.cos_outer) / max(light.cos_inner - light.cos_outer, 1e-4), 0.0, 1.0));
    }
    return min(light.color * (window * cone / d2), vec3(MOST_IRRADIANCE));
}

// How much of the surroundings the surface sees; 1 where nothing was estimated, as where rays hit. Ambient light alone
// is dimmed by it.
float ambient_visibility = 1.0;

vec3 shade(Surface s, vec3 emission, vec3 position, vec3 v) {
    float nv = max(dot(s.normal, v), 1e-4);
    vec3 specular = specular_albedo(s.f0, nv, s.roughness);
    vec3 sum = emission + s.albedo * (1.0 - specular) * environment_irradiance(s.normal) * ambient_visibility;
    if (s.roughness > frame.ray_roughness_limit) {
        sum += specular * environment_specular(reflect(-v, s.normal), s.roughness) * ambient_visibility;
    }
    float alpha = square(max(s.roughness, PUNCTUAL_ROUGHNESS));
    for (uint i = 0u; i < frame.light_count; ++i) {
        vec3 l;
        vec3 e = incident(lights[i], position, l);
        float nl = dot(s.normal, l);
        if (nl <= 0.0) continue;
        vec3 f = schlick(s.f0, max(dot(v, normalize_or(v + l, s.normal)), 0.0));
        sum += e * (s.albedo * (1.0 - f) * (nl / PI) + ggx_times_cosine(s.normal, v, l, alpha, s.f0));
    }
    return sum;
}

#endif
