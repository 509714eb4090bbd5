// The pixel of an invocation in passes where the eyes share their shading: a pixel of the left eye's grid (`listed` 0), or one
// of the listed pixels of the right eye (`listed` 1). Needs `frame`, `rays`, `arguments` and `listed` from the includer. Groups
// hold 64 invocations.
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
    // From a push constant the compiler knows that all invocations have the same eye. A software device then loads the eye's
    // constants once.
    texel.z = int(listed);
    return found;
}

#endif
