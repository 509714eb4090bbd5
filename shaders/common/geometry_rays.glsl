// The bindings of every pass that sends listed rays through the scene's geometry (twin: `bind_geometry_rays` in bvh.rs): the
// frame, the list, the lights, the scene as rays.glsl and hit_surface.glsl read it, the G-buffer, what shade.glsl reads, and
// baked light.
#ifndef GEOMETRY_RAYS_GLSL
#define GEOMETRY_RAYS_GLSL

layout(binding = 0, std140) uniform Frames { FrameUniform frame; };
layout(binding = 1, std430) readonly buffer Rays { uint rays[]; };
layout(binding = 2, std430) readonly buffer Arguments { uint arguments[4]; };
layout(binding = 3, std430) buffer Counters { CountersData counters; };
layout(binding = 4, std430) readonly buffer Lights { LightData lights[]; };
#ifdef RAY_QUERY
layout(binding = 5) uniform accelerationStructureEXT ray_structure;
#else
layout(binding = 5) uniform usampler2D node_rows;
#endif
layout(binding = 6) uniform usampler2D triangle_rows;
layout(binding = 7, std430) readonly buffer Instances { InstanceData instances[]; };
layout(binding = 8, std430) readonly buffer Materials { MaterialData materials[]; };
layout(binding = 9, std430) readonly buffer Textures { TextureData textures[]; };
layout(binding = 10, std430) readonly buffer Texels { uint texels[]; };
layout(binding = 11, std430) readonly buffer Vertices { float vertices[]; };
layout(binding = 12, std430) readonly buffer Indices { uint indices[]; };
layout(binding = 13) uniform usampler2DArray surface_image;
layout(binding = 14) uniform sampler2DArray depth_image;
layout(binding = 15) uniform sampler2D environment_map;
layout(binding = 16) uniform sampler2D irradiance_map;
layout(binding = 17) uniform sampler2D specular_map;
layout(binding = 18) uniform sampler2D brdf_table;
layout(binding = 19) uniform usampler2D patch_rows;
layout(binding = 20) uniform usampler2D light_rows;

#endif
