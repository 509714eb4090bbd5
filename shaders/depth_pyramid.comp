#version 460
// In: front depth, back-face depth, G-buffer. Out: for each cell the nearest front and the farthest back, as raw reverse-Z
// depth, in seven levels of both eyes by one dispatch (Uludag 2018; the paper's §4.1 for the second channel).
// A group reduces a tile of 64×64 pixels. Pixels beyond the image have the identity of the reduction, so that cell = pixel >>
// level for any size of the image.
// Reference: never.
#extension GL_GOOGLE_include_directive : require
#include "common/shared.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
// 1: a back-face image is bound; 0: every mesh counts as open.
layout(constant_id = 0) const uint HAS_BACK_FACES = 1u;
// 1: an open mesh is at least as thick as the depth of its surface varies within the pixel, so that no ray slips between the
// pixels of a slanted surface; 0: only as thick as open_mesh_thickness.
layout(constant_id = 1) const uint CLOSE_SLOPES = 0u;

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1) uniform sampler2DArray depth_image;
layout(binding = 2, rg32f) writeonly uniform image2DArray level0;
layout(binding = 3, rg32f) writeonly uniform image2DArray level1;
layout(binding = 4, rg32f) writeonly uniform image2DArray level2;
layout(binding = 5, rg32f) writeonly uniform image2DArray level3;
layout(binding = 6, rg32f) writeonly uniform image2DArray level4;
layout(binding = 7, rg32f) writeonly uniform image2DArray level5;
layout(binding = 8, rg32f) writeonly uniform image2DArray level6;
layout(binding = 9) uniform sampler2DArray back_image;
layout(binding = 10) uniform usampler2DArray surface_image;

#include "common/camera.glsl"
#include "common/surface.glsl"

// The depths of a cell without matter.
const vec2 IDENTITY = vec2(0.0, 1e30);

shared vec2 cells[32 * 32];

vec2 join(vec2 a, vec2 b) { return vec2(max(a.x, b.x), min(a.y, b.y)); }

vec2 base(ivec3 texel) {
    if (any(greaterThanEqual(texel.xy, ivec2(frame.size)))) return IDENTITY;
    float front = texelFetch(depth_image, texel, 0).x;
    if (front == 0.0) return IDENTITY;
    float back = HAS_BACK_FACES != 0u ? texelFetch(back_image, texel, 0).x : 0.0;
    if (back == 0.0) {
        // An open mesh has matter of thickness open_mesh_thickness behind its surface.
        float near = frame.eyes[texel.z].position_near.w;
        back = near / (near / front + frame.open_mesh_thickness);
        if (CLOSE_SLOPES != 0u) {
            // The raw depth of a plane is linear in the image. It falls by this much from the pixel's centre to its farthest
            // corner.
            vec3 n = unpack_direction(texelFetch(surface_image, texel, 0).y);
            float along = abs(dot(n, scaled_ray(texel.z, vec2(texel.xy) + 0.5)));
            float across = abs(dot(n, frame.eyes[texel.z].ray_across.xyz)) + abs(dot(n, frame.eyes[texel.z].ray_down.xyz));
            // Bounded where the plane is seen edge-on: the back's raw depth is at least half the front's.
            back = min(back, front * max(1.0 - 0.5 * across / max(along, 1e-6), 0.5));
        }
    }
    return vec2(front, back);
}

void store(int level, ivec3 cell, vec2 v) {
    vec4 value = vec4(v, 0.0, 0.0);
    if (level == 1) imageStore(level1, cell, value);
    else if (level == 2) imageStore(level2, cell, value);
    else if (level == 3) imageStore(level3, cell, value);
    else if (level == 4) imageStore(level4, cell, value);
    else if (level == 5) imageStore(level5, cell, value);
    else imageStore(level6, cell, value);
}

void main() {
    ivec2 local = ivec2(gl_LocalInvocationID.xy);
    ivec2 tile = ivec2(gl_WorkGroupID.xy);
    int eye = int(gl_WorkGroupID.z);
    // Each invocation reduces sixteen pixels to four cells of level 1.
    for (int i = 0; i < 4; ++i) {
        ivec2 cell = local * 2 + ivec2(i & 1, i >> 1);
        ivec2 pixel = tile * 64 + cell * 2;
        vec2 v = IDENTITY;
        for (int k = 0; k < 4; ++k) {
            ivec3 texel = ivec3(pixel + ivec2(k & 1, k >> 1), eye);
            vec2 b = base(texel);
            imageStore(level0, texel, vec4(b, 0.0, 0.0));
            v = join(v, b);
        }
        cells[cell.y * 32 + cell.x] = v;
        store(1, ivec3(tile * 32 + cell, eye), v);
    }
    // The further levels are reduced in place: cell (x, y) of a level lies at (x, y) << (level − 1).
    int index = int(gl_LocalInvocationIndex);
    for (int level = 2; level <= 6; ++level) {
        barrier();
        int side = 64 >> level;
        if (index < side * side) {
            ivec2 cell = ivec2(index % side, index / side);
            int stride = 1 << (level - 2);
            int at = (cell.y * 32 + cell.x) * 2 * stride;
            vec2 v = join(join(cells[at], cells[at + stride]), join(cells[at + 32 * stride], cells[at + 33 * stride]));
            // Only this invocation reads these four cells, so it may write the first of them.
            cells[at] = v;
            store(level, ivec3(tile * side + cell, eye), v);
        }
    }
}
