// Light from infinity. Needs `environment_map`, `irradiance_map` and `specular_map` from the includer (sampler2D; the last one
// holds its prefiltered levels one below the other).
#ifndef ENVIRONMENT_GLSL
#define ENVIRONMENT_GLSL
#include "math.glsl"

// The map's middle column looks along −Z, and its top row looks up.
vec2 equirect_uv(vec3 d) {
    return vec2(atan(d.x, -d.z) / (2.0 * PI) + 0.5, acos(clamp(d.y, -1.0, 1.0)) / PI);
}

vec3 environment_radiance(vec3 d) { return textureLod(environment_map, equirect_uv(d), 0.0).rgb; }

// Irradiance / π.
vec3 environment_irradiance(vec3 n) { return textureLod(irradiance_map, equirect_uv(n), 0.0).rgb; }

// Each level is twice as wide as high.
float specular_levels() {
    ivec2 size = textureSize(specular_map, 0);
    return float(size.y * 2 / size.x);
}

vec3 specular_level(vec2 uv, float level) {
    // v stays half a texel away from the level's borders, so that neighbouring levels do not bleed into each other.
    float levels = specular_levels();
    float rows = float(textureSize(specular_map, 0).y) / levels;
    float v = clamp(uv.y, 0.5 / rows, 1.0 - 0.5 / rows);
    return textureLod(specular_map, vec2(uv.x, (level + v) / levels), 0.0).rgb;
}

// GGX-prefiltered radiance about d.
vec3 environment_specular(vec3 d, float roughness) {
    float top = specular_levels() - 1.0;
    float level = clamp(roughness, 0.0, 1.0) * top;
    vec2 uv = equirect_uv(d);
    float below = floor(level);
    return mix(specular_level(uv, below), specular_level(uv, min(below + 1.0, top)), level - below);
}

#endif
