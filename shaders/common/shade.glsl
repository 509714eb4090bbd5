// Light that leaves a surface towards v without its traced reflection: emission, punctual lights, the diffuse environment,
// and the specular environment where the surface is too rough for a ray. Shadows are in shadow.glsl.
// The `lighting` pass and the hits of rays use the same functions. Needs `lights` (LightData[]), `brdf_table` (sampler2D:
// F0·A + B) and what environment.glsl needs.
#ifndef SHADE_GLSL
#define SHADE_GLSL
#include "environment.glsl"
#include "lights.glsl"
#include "surface.glsl"

// Directional albedo of the specular lobe, F0·A + B; brdf_table.comp integrated A and B from the functions of brdf.glsl.
vec3 specular_albedo(vec3 f0, float nv, float roughness) {
    vec2 size = vec2(textureSize(brdf_table, 0));
    vec2 uv = (vec2(clamp(nv, 0.0, 1.0), clamp(roughness, 0.0, 1.0)) * (size - 1.0) + 0.5) / size;
    vec2 ab = textureLod(brdf_table, uv, 0.0).xy;
    return f0 * ab.x + ab.y;
}

// How much of its surroundings the surface sees; 1 where it was not estimated, as at the hits of rays. It dims ambient light
// alone.
float ambient_visibility = 1.0;

// The light without that of the punctual lights.
vec3 shade_without_lights(Surface s, vec3 emission, vec3 v) {
    float nv = max(dot(s.normal, v), 1e-4);
    vec3 specular = specular_albedo(s.f0, nv, s.roughness);
    vec3 sum = emission + s.albedo * (1.0 - specular) * environment_irradiance(s.normal) * ambient_visibility;
    if (s.roughness > frame.ray_roughness_limit) {
        sum += specular * environment_specular(reflect(-v, s.normal), s.roughness) * ambient_visibility;
    }
    return sum;
}

// The same where the light around the surface is known (`ambient`, irradiance / π). It replaces the diffuse environment, and
// also the specular one of a surface that is too rough for a ray.
vec3 shade_without_lights_in(vec3 ambient, Surface s, vec3 emission, vec3 v) {
    vec3 specular = specular_albedo(s.f0, max(dot(s.normal, v), 1e-4), s.roughness);
    vec3 share = s.albedo * (1.0 - specular);
    if (s.roughness > frame.ray_roughness_limit) share += specular;
    return emission + share * ambient * ambient_visibility;
}

// With the punctual lights, none of which casts a shadow.
vec3 shade(Surface s, vec3 emission, vec3 position, vec3 v) {
    vec3 sum = shade_without_lights(s, emission, v);
    for (uint i = 0u; i < frame.light_count; ++i) sum += from_light(lights[i], s, position, v);
    return sum;
}

#endif
