#version 460
// In: points on the scene's surfaces, the scene's BVH, lights, environment, the light of the previous round. Out: the light
// that each point gathers, as irradiance / π, and the share of its rays that met the back of a surface.
// Emissive surfaces are sampled by the rays and by points chosen on the emitters. The two are weighted by the balance heuristic
// (Veach 1997), so that neither small lamps nor large emitters near by leave bright spots.
// One round adds one bounce: each hit is shaded by the lights, its emission and the light that the previous round baked there.
#extension GL_GOOGLE_include_directive : require
#ifdef RAY_QUERY
#extension GL_EXT_ray_query : require
#endif
// Both sides of a surface stop light; only views look through the back of an open mesh.
#define TWO_SIDED
// A point light inside the mesh of its bulb would put bright spots on the walls by way of the bulb. Here every light counts as
// at least 0.15 m away.
#define NEAREST_SQUARED 0.0225
#include "common/shared.glsl"

layout(local_size_x = 64) in;
layout(constant_id = 0) const uint HAS_MASK = 1u;
layout(constant_id = 1) const uint SHADOWS = 1u;
layout(constant_id = 2) const uint HAS_GLASS = 1u;
layout(constant_id = 3) const uint INDIRECT = 1u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Lights { LightData lights[]; };
#ifdef RAY_QUERY
layout(binding = 2) uniform accelerationStructureEXT ray_structure;
#else
layout(binding = 2) uniform usampler2D node_rows;
#endif
layout(binding = 3) uniform usampler2D triangle_rows;
layout(binding = 4, std430) readonly buffer Instances { InstanceData instances[]; };
layout(binding = 5, std430) readonly buffer Materials { MaterialData materials[]; };
layout(binding = 6, std430) readonly buffer Textures { TextureData textures[]; };
layout(binding = 7, std430) readonly buffer Texels { uint texels[]; };
layout(binding = 8, std430) readonly buffer Vertices { float vertices[]; };
layout(binding = 9, std430) readonly buffer Indices { uint indices[]; };
layout(binding = 10) uniform sampler2D environment_map;
layout(binding = 11) uniform sampler2D irradiance_map;
layout(binding = 12) uniform sampler2D specular_map;
layout(binding = 13) uniform sampler2D brdf_table;
layout(binding = 14) uniform usampler2D patch_rows;
layout(binding = 15) uniform usampler2D light_rows;
// Two words of four floats for each point: position and lift off the surface; normal.
layout(binding = 16, std430) readonly buffer Points { vec4 points[]; };
layout(binding = 17, std430) writeonly buffer Gathered { vec4 gathered[]; };
layout(binding = 18, std430) readonly buffer Emitters { EmitterData emitters[]; };
layout(push_constant) uniform Constants {
    uint first_point;
    uint point_count;
    uint ray_count;
    uint round;
    uint emitter_count;
    float emitted;      // Σ area × luminance over the emitters
};

#include "common/hit_surface.glsl"
#include "common/shade_hit.glsl"

// When it reflects light to other surfaces, a surface counts as at least this rough (path regularisation, Kaplanyan &
// Dachsbacher 2013). Few rays would find the highlights of polished metal, which would be noise.
const float LEAST_ROUGHNESS = 0.6;
// The largest number of transmitting surfaces that a ray goes through.
const uint MOST_SHEETS = 8u;

// The density, over solid angle, with which `from_emitter` chooses a point on an emissive triangle. `distance`: from the point
// that gathers; `cosine`: between the emitter's normal and the direction.
float emitter_density(uint triangle, float distance, float cosine) {
    uint m = instances[floatBitsToUint(row(triangle_rows, 3u * triangle).w)].material;
    float over_area = min(luminance(materials[m].emissive), 1e12) / emitted;
    return over_area * distance * distance / max(cosine, 1e-6);
}

float cosine_at(uint triangle, vec3 direction) {
    vec3 e1 = row(triangle_rows, 3u * triangle + 1u).xyz, e2 = row(triangle_rows, 3u * triangle + 2u).xyz;
    return abs(dot(normalize_or(cross(e1, e2), direction), direction));
}

// One sample of the irradiance / π by a point chosen on an emitter, with its weight of the balance heuristic.
vec3 from_emitter(vec3 origin, vec3 normal, Draws draws) {
    float u = draw_2d(draws, DRAW_EMITTER).x;
    uint low = 0u, high = emitter_count - 1u;
    while (low < high) {
        uint middle = (low + high) / 2u;
        if (emitters[middle].cumulative > u) high = middle;
        else low = middle + 1u;
    }
    uint triangle = emitters[low].triangle;
    vec2 p = draw_2d(draws, DRAW_EMITTER_POINT);
    float r = sqrt(p.x);
    vec2 uv = vec2(r * (1.0 - p.y), r * p.y);
    vec4 w2 = row(triangle_rows, 3u * triangle + 2u);
    vec3 there = row(triangle_rows, 3u * triangle).xyz + uv.x * row(triangle_rows, 3u * triangle + 1u).xyz + uv.y * w2.xyz;
    vec3 toward = there - origin;
    float distance = length(toward);
    if (distance == 0.0) return vec3(0.0);
    vec3 direction = toward / distance;
    float cosine = dot(normal, direction);
    if (cosine <= 0.0) return vec3(0.0);
    if (sees_back(triangle, direction) && (floatBitsToUint(w2.w) & DOUBLE_SIDED) == 0u) return vec3(0.0);
    vec3 arrives = transmittance(origin, toward, 1.0 - 1e-3);
    if (all(equal(arrives, vec3(0.0)))) return vec3(0.0);
    vec3 emission;
    hit_surface(Intersection(distance, uv, triangle), -direction, emission);
    float density = emitter_density(triangle, distance, cosine_at(triangle, direction));
    return emission * arrives * (cosine / PI) / (density + cosine / PI);
}

// The radiance that arrives at `origin` from `direction`. `back`: the ray ended at the back of a surface.
vec3 arriving(vec3 origin, vec3 direction, float cosine, Draws draws, out bool back) {
    back = false;
    vec3 start = origin;
    vec3 share = vec3(1.0), sum = vec3(0.0);
    for (uint sheet = 0u; sheet < MOST_SHEETS; ++sheet) {
        Intersection hit = intersect(origin, direction);
        if (hit.triangle == NO_TRIANGLE) return sum + share * environment_radiance(direction);
        uint flags = floatBitsToUint(row(triangle_rows, 3u * hit.triangle + 2u).w);
        vec3 there = origin + direction * hit.t;
        bool is_back = sees_back(hit.triangle, direction);
        bool through = HAS_GLASS != 0u && (flags & TRANSMITS) != 0u;
        if (is_back && (flags & DOUBLE_SIDED) == 0u) {
            back = !through;
        } else {
            vec3 emission;
            Surface s = hit_surface(hit, -direction, emission);
            if (emitter_count > 0u && any(greaterThan(emission, vec3(0.0)))) {
                float other = emitter_density(hit.triangle, length(there - start), cosine_at(hit.triangle, direction));
                emission *= (cosine / PI) / (cosine / PI + other);
            }
            s.roughness = max(s.roughness, LEAST_ROUGHNESS);
            vec3 radiance = shade_hit(s, emission, hit, there, -direction, draws);
            // The surface's reflection is not traced further. In its place, the lobe reflects the light baked around the hit.
            if (s.roughness <= frame.ray_roughness_limit) {
                vec3 lobe = specular_albedo(s.f0, max(dot(s.normal, -direction), 1e-4), s.roughness);
                radiance += lobe * baked_light(hit.triangle, hit.uv, is_back);
            }
            sum += share * min(radiance, vec3(65504.0));
        }
        if (!through) break;
        share *= let_through(hit.triangle, hit.uv);
        origin = there + direction * (SHADOW_OFFSET * max(length(there), hit.t));
    }
    return sum;
}

void main() {
    uint k = gl_GlobalInvocationID.x;
    if (k >= point_count) return;
    uint point = first_point + k;
    vec4 at = points[2u * point];
    vec3 normal = points[2u * point + 1u].xyz;
    vec3 origin = at.xyz + normal * at.w;
    mat3 local = basis(normal);
    vec3 sum = vec3(0.0);
    float backs = 0.0;
    for (uint i = 0u; i < ray_count; ++i) {
        Draws draws = Draws(round, 0u, uvec2(point, 0u), i);
        // Cosine-weighted: a point of the disc, projected up to the hemisphere (Malley).
        vec2 d = on_disc(draw_2d(draws, DRAW_GATHER));
        vec3 direction = local * vec3(d, sqrt(max(1.0 - dot(d, d), 0.0)));
        direction = normalize(direction);
        bool back;
        sum += arriving(origin, direction, dot(normal, direction), draws, back);
        if (emitter_count > 0u) sum += from_emitter(origin, normal, draws);
        if (back) backs += 1.0;
    }
    gathered[point] = vec4(sum, backs) / float(ray_count);
}
