#version 460
// Out: A and B of the specular lobe's albedo F0·A + B by n·v (x) and roughness (y). They are integrated from the same
// functions that trace and resolve use, because a published fit would describe another BRDF (Karis 2013 for the split).
#extension GL_GOOGLE_include_directive : require
#include "common/brdf.glsl"
#include "common/random.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, rgba16f) writeonly uniform image2D table;
layout(push_constant) uniform Constants { float delta_roughness; uint samples; };

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(table);
    if (any(greaterThanEqual(texel, size))) return;
    vec2 at = vec2(texel) / vec2(size - 1);
    float nv = max(at.x, 1e-3);
    float m = pow(1.0 - nv, 5.0);
    vec2 ab = vec2(1.0 - m, m);
    if (at.y >= delta_roughness) {
        float alpha = at.y * at.y;
        vec3 n = vec3(0.0, 0.0, 1.0), v = vec3(sqrt(1.0 - nv * nv), 0.0, nv);
        ab = vec2(0.0);
        for (uint i = 0u; i < samples; ++i) {
            vec3 l = sample_reflection(v, alpha, sample_2d(0u, 0u, uvec2(texel), i));
            if (l.z <= 0.0) continue;
            // With F0 = 1 the Fresnel term is 1, and this is f·cos/p without it.
            float w = ggx_times_cosine(n, v, l, alpha, vec3(1.0)).x / reflection_pdf(v, l, alpha);
            float f = schlick(vec3(0.0), dot(v, normalize_or(v + l, n))).x;
            ab += w * vec2(1.0 - f, f);
        }
        ab /= float(samples);
    }
    imageStore(table, texel, vec4(ab, 0.0, 0.0));
}
