// The pixel of an invocation in a dispatch over a list, one invocation for each listed pixel. Needs `rays` and `arguments`
// from the includer.
#ifndef RAY_LIST_GLSL
#define RAY_LIST_GLSL

uint pack_pixel(ivec3 texel) { return uint(texel.x) | uint(texel.y) << 14 | uint(texel.z) << 28; }

bool listed_pixel(out ivec3 texel) {
    uint index = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * 64u + gl_LocalInvocationIndex;
    if (index >= arguments[3]) return false;
    uint packed = rays[index];
    texel = ivec3(packed & 0x3fffu, packed >> 14 & 0x3fffu, packed >> 28);
    return true;
}

#endif
