#version 460
// In: G-buffer, lights, their shadow maps. Out: the outgoing light of the punctual lights at each pixel, with shadows.
// An alternative to shadows.comp that traces no rays.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(constant_id = 0) const uint HAS_GLASS = 1u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Lights { LightData lights[]; };
layout(binding = 2, std430) readonly buffer Maps { ShadowMapData maps[]; };
layout(binding = 3, std430) readonly buffer LightMaps { LightMapsData light_maps[]; };
layout(binding = 4) uniform sampler2DArray shadow_map;
layout(binding = 5) uniform usampler2DArray surface_image;
layout(binding = 6) uniform sampler2DArray depth_image;
layout(binding = 7, rgba32f) writeonly uniform image2DArray direct_image;
// Added to a position in render space to get the position in the maps' space, metres.
layout(push_constant) uniform Constants { vec3 maps_from_render; };

#include "common/camera.glsl"
#include "common/lights.glsl"
#include "common/random.glsl"
#include "common/shadow_map.glsl"

// As in shadow.glsl: how far a point is lifted off its plane, as a share of the distance from the head.
const float SHADOW_OFFSET = 2e-4;

// A random angle for a place, hashed from a cube about as wide as a pixel. It is the same for both eyes, except for rounding.
float turn_at(vec3 place, float width) {
    ivec3 cell = ivec3(floor(place / exp2(ceil(log2(max(width, 1e-12))))));
    return 2.0 * PI * unit_float(combine(combine(combine(0u, uint(cell.x)), uint(cell.y)), uint(cell.z)));
}

void main() {
    uvec3 id = gl_GlobalInvocationID;
    if (any(greaterThanEqual(id.xy, frame.size))) return;
    ivec3 texel = ivec3(id);
    uint eye = id.z;
    vec2 center = vec2(id.xy) + 0.5;
    float depth = texelFetch(depth_image, texel, 0).x;
    vec3 direct = vec3(0.0);
    if (depth != 0.0) {
        Surface s = unpack_surface(texelFetch(surface_image, texel, 0));
        vec3 position = render_position(eye, center, depth);
        vec3 v = normalize(eye_position(eye) - position);
        vec3 origin = position + s.face_normal * (SHADOW_OFFSET * length(position));
        float turn = turn_at(position + maps_from_render, pixel_size(eye) * view_distance(eye, depth));
        for (uint i = 0u; i < frame.light_count; ++i) {
            vec3 light = from_light(lights[i], s, position, v);
            if (all(equal(light, vec3(0.0)))) continue;
            if (lights[i].casts_shadow != 0u) {
                vec3 toward = lights[i].kind == 0u ? -lights[i].direction : lights[i].position - origin;
                if (dot(toward, s.face_normal) <= 0.0) continue;
                LightData of = lights[i];
                of.position += maps_from_render;
                light *= mapped_share(i, of, origin + maps_from_render, s.face_normal, turn);
            }
            direct += light;
        }
    }
    imageStore(direct_image, texel, vec4(direct, 1.0));
}
