// The pixel of an invocation where shading is shared: of the left eye's grid (`listed` 0), or one of the right eye's that
// are listed (1). Needs `frame`, `rays`, `arguments` and `listed` from the includer. Groups hold 64 invocations.
#ifndef LEFT_OR_LISTED_GLSL
#define LEFT_OR_LISTED_GLSL
#include "ray_list.glsl"

bool left_or_listed(out ivec3 texel) {
    bool found;
    if (listed != 0u) {
        found = listed_pixel(texel);
    } else {
        texel = ivec3(gl_GlobalInvocationID.xy, 0);
        found = all(lessThan(gl_GlobalInvocationID.xy, frame.size));
    }
    // Known to be the same for all invocations, so that a software device loads what belongs to the eye once.
    texel.z = int(listed);
    return found;
}

#endif
