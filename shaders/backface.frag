#version 460
// In: back faces of closed meshes, the front depth. Out: the nearest back face behind the front of its pixel.
// The paper's §4.1. Back faces before the front are discarded: they would give the surface no thickness, and rays would pass.
// Reference: never.

layout(set = 0, binding = 2) uniform sampler2DArray front_depth;
layout(push_constant) uniform Constants { uint eye; };

void main() {
    float front = texelFetch(front_depth, ivec3(gl_FragCoord.xy, eye), 0).x;
    if (gl_FragCoord.z >= front) discard;
}
